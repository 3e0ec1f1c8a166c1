"""A file with regions, and how its steps are judged."""

from __future__ import annotations

from pathlib import Path

from sdc_workshop.exam import typical
from sdc_workshop.exam.answer import PASSED, UNFINISHED, WAITING, WRONG, Answer, Problem, wrong
from sdc_workshop.exam.hints import hint_of
from sdc_workshop.exam.output import Crash, meaning
from sdc_workshop.exam.student import NotBuilt
from sdc_workshop.exam.variant import Variant, make
from sdc_workshop.regions import RegionError, body, is_written, regions, template
from sdc_workshop.steps import load_steps
from sdc_workshop.workspace import PACKAGE, PROJECT, SOLUTION, TEMPLATES

BUILD = "In the folder of your workspace: `catkin_make`, and then `source devel/setup.bash` in this terminal."


class Subject:
    """Judges the regions `todos` of a file. `left_empty` are regions that belong to later steps, of which nothing may be needed yet."""

    file: str
    todos: tuple
    left_empty: tuple = ()
    # Messages without whose classes none of these regions can be tried.
    needs: tuple = ()
    needs_build = True

    def problems(self, variant: Variant, stage) -> list:
        """What is wrong with a variant of the file, the most telling first; nothing when all is well. Raises NotBuilt."""
        raise NotImplementedError

    def syntax_problem(self, variant: Variant) -> Problem | None:
        """What keeps the file from being read at all."""
        if not self.file.endswith(".py"):
            return None
        try:
            compile(variant.text, self.file, "exec", dont_inherit=True)
        except (SyntaxError, ValueError) as error:
            line = getattr(error, "lineno", None)
            found = Crash(f"{type(error).__name__}: {getattr(error, 'msg', error)}", line)
            shown = (
                variant.text.split("\n")[line - 1].strip()
                if line and line <= variant.text.count("\n") + 1
                else ""
            )
            return Problem(
                "a file that Python can read",
                f"{found.error}{': ' + shown if shown else ''}",
                meaning(found),
                line=line,
            )
        return None

    def written(self, text: str, todo: str) -> bool:
        """Whether a student has begun with a region."""
        if regions(text)[todo].first == 0:
            return bool(body(text, todo).strip())
        return is_written(text, todo)

    # ---- judging -------------------------------------------------------------

    def answers(self, steps: list, student, stage) -> dict:
        """{id: Answer} for some steps of this file."""
        path = f"src/{self.file}"
        text = student.text(self.file)
        if text is None:
            return self._all(
                steps,
                Answer(
                    WRONG,
                    f"the file {path}",
                    "it is not there",
                    f"Bring it back: cp {TEMPLATES / self.file} {path}",
                    path,
                ),
            )
        try:
            found = regions(text)
        except RegionError as error:
            line = (
                int(str(error).split()[1].rstrip(":")) if str(error).startswith("line ") else None
            )
            return self._all(
                steps,
                Answer(
                    WRONG,
                    "the TODO lines and the rules below them as they were",
                    str(error),
                    "Your lines go between the two; both stay.",
                    path,
                    line,
                ),
            )
        answers, begun = {}, []
        for step in steps:
            if step.todo not in found:
                answers[step.id] = Answer(
                    WRONG,
                    f"a line that begins with '# TODO {step.todo}:' and a rule below it",
                    "there is no such line",
                    f"Look it up in {TEMPLATES / self.file} and put both lines back.",
                    path,
                )
            elif not self.written(text, step.todo):
                answers[step.id] = Answer(
                    UNFINISHED,
                    found[step.todo].title,
                    "nothing is written there yet",
                    hint_of(step.id).hint,
                    path,
                    found[step.todo].line,
                )
            else:
                begun.append(step)
        waits = self._waits(student) if begun else None
        if waits is not None:
            answers.update({step.id: waits for step in begun})
        elif begun:
            try:
                answers.update(self._judge(begun, text, stage))
            except NotBuilt as error:
                answers.update(
                    {
                        step.id: Answer(WAITING, "a workspace that is built", str(error), BUILD)
                        for step in begun
                    }
                )
        return answers

    @staticmethod
    def _all(steps, answer) -> dict:
        later = Answer(
            WAITING,
            "",
            f"the file must be mended first, see {steps[0].id}",
            "",
            answer.file,
            answer.line,
        )
        return {step.id: answer if step is steps[0] else later for step in steps}

    def _waits(self, student) -> Answer | None:
        """What stands in the way before anything can be tried."""
        if not self.needs_build:
            return None
        for message in self.needs:
            if student.built_md5(message) != solution_md5(message):
                made = (student.src / PACKAGE / "msg" / f"{message}.msg").is_file()
                return Answer(
                    WAITING,
                    f"the class of the message {message}, built from {PACKAGE}/msg/{message}.msg",
                    "it was built from another text of the file"
                    if student.built_md5(message)
                    else "it has not been built",
                    f"{BUILD} `./workshop/check messages` says what is not right yet."
                    if made
                    else "`./workshop/check messages` says what to make first.",
                )
        return None

    def _judge(self, steps, text, stage) -> dict:
        path = f"src/{self.file}"
        outside = self.syntax_problem(self._variant(text, ()))
        if outside is not None:
            return self._all(
                steps, wrong(self._outside(text, outside), path, self._changed_line(text))
            )
        answers, sound = {}, []
        for step in steps:
            problem = self.syntax_problem(self._variant(text, (step.todo,)))
            if problem is not None:
                answers[step.id] = self._wrong(
                    self._variant(text, (step.todo,)), step.todo, problem
                )
            else:
                sound.append(step)
        if not sound:
            return answers
        together = self._variant(text, tuple(step.todo for step in sound))
        found = self.problems(together, stage)
        if not found:
            return {**answers, **{step.id: Answer(PASSED) for step in sound}}
        if len(sound) == 1:
            answers[sound[0].id] = self._blame(together, sound[0].todo, found, text, stage)
            return answers
        for step in sound:
            variant = self._variant(text, (step.todo,))
            alone = self.problems(variant, stage)
            answers[step.id] = (
                self._blame(variant, step.todo, alone, text, stage) if alone else Answer(PASSED)
            )
        if all(answers[step.id].status == PASSED for step in sound):
            step = next((step for step in sound if step.todo == found[0].todo), sound[0])
            problem = Problem(
                found[0].expected,
                found[0].seen,
                "Each TODO is right for itself, but together they are not: do they use the same names? "
                + found[0].hint,
                line=found[0].line,
            )
            answers[step.id] = self._wrong(together, step.todo, problem)
        return answers

    def _variant(self, text, judged) -> Variant:
        return make(self.file, text, judged, self.left_empty)

    def _blame(self, variant, todo, found, text, stage) -> Answer:
        """The answer to the step that these problems are the fault of."""
        if template(text) != template((SOLUTION / self.file).read_text(encoding="utf-8")):
            outside = self.problems(self._variant(text, ()), stage)
            if outside:
                return wrong(
                    self._outside(text, outside[0]), f"src/{self.file}", self._changed_line(text)
                )
        return self._wrong(
            variant, todo, next((problem for problem in found if problem.todo == todo), found[0])
        )

    def _wrong(self, variant, todo, problem) -> Answer:
        hint = problem.hint
        region = regions(variant.text)[todo]
        if problem.is_error:
            hint = f"{hint} {hint_of(self._step(todo)).hint}"
        if self.file.endswith(".py"):
            hint = " ".join([*typical.mistakes(body(variant.text, todo), region), hint]).strip()
        return Answer(
            WRONG,
            problem.expected,
            problem.seen,
            hint,
            f"src/{self.file}",
            variant.student_line(problem.line, todo),
        )

    def _step(self, todo) -> str:
        return next(step.id for step in load_steps() if (step.file, step.todo) == (self.file, todo))

    def _outside(self, text, problem) -> Problem:
        line = self._changed_line(text) or problem.line
        return Problem(
            problem.expected,
            problem.seen,
            f"The fault lies outside of your TODOs{f', near line {line}' if line else ''}: something there was changed. Compare with "
            f"{TEMPLATES / self.file}. {problem.hint}",
            line=problem.line,
        )

    def _changed_line(self, text) -> int | None:
        """The first line outside of all regions that is not as it was given, as the student's file counts."""
        given = template((SOLUTION / self.file).read_text(encoding="utf-8")).split("\n")
        inside = {
            line for region in regions(text).values() for line in range(region.first, region.end)
        }
        inside_given = {
            line
            for region in regions("\n".join(given)).values()
            for line in range(region.first, region.end)
        }
        lines = [
            (index, line) for index, line in enumerate(text.split("\n")) if index not in inside
        ]
        wanted = [line for index, line in enumerate(given) if index not in inside_given]
        for (index, line), original in zip(lines, wanted):
            if line != original:
                return index + 1
        return None


def solution_md5(message: str) -> str | None:
    """Fingerprint of a message of the finished car."""
    from sdc_workshop.exam.student import Student

    return Student(PROJECT / "catkin_ws").built_md5(message)


def name_of(file: str) -> str:
    """The name of the node that a script is."""
    return Path(file).stem
