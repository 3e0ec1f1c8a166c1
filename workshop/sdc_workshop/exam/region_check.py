"""A file with regions, and how its steps are checked."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from sdc_workshop.exam import typical
from sdc_workshop.exam.answer import PASSED, UNFINISHED, Answer, in_full, listed, mistake
from sdc_workshop.exam.families import UNKNOWN
from sdc_workshop.exam.output import Crash, crash, meaning
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import NotBuilt, Student
from sdc_workshop.exam.variant import Variant, make
from sdc_workshop.regions import RegionError, body, is_written, regions, template
from sdc_workshop.steps import all_steps, hint_of
from sdc_workshop.workspace import PACKAGE, PROJECT, UPDATE, solution_text

BUILD = (
    "In the folder of your workspace: `catkin_make`, then `source devel/setup.bash` in this "
    "terminal."
)


def file_answers(steps: list, answer: Answer) -> dict:
    """Return the answers to the steps of a file with a problem of the whole file, by step id."""
    later = listed("fix_first", answer.file, answer.line, first=steps[0].id)
    return {step.id: answer if step is steps[0] else later for step in steps}


class RegionCheck:
    """Checks the regions of one file."""

    file: str  # path relative to the src folder
    todos: tuple  # numbers of the regions that it checks
    left_empty: tuple = ()  # regions of later steps, which stay as in the template
    needs: tuple = ()  # messages whose classes must be built before any of these regions can run
    needs_build = True  # whether the workspace must be built
    waits_for = ""  # what takes longer than reading the file, for people

    def problems(self, variant: Variant, stage: Stage) -> list:
        """Return what is wrong with a variant of the file, the most useful problem first.

        Raises:
            NotBuilt: the workspace is not built
        """
        raise NotImplementedError

    def syntax_problem(self, variant: Variant) -> Answer | None:
        """Return why Python cannot parse the file, or None."""
        if not self.file.endswith(".py"):
            return None
        try:
            # As bytes: a comment can name the encoding.
            compile(variant.text.encode(), self.file, "exec", dont_inherit=True)
        except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
            line = getattr(error, "lineno", None)
            found = Crash(f"{type(error).__name__}: {getattr(error, 'msg', error)}", line)
            shown = (getattr(error, "text", None) or "").strip()
            error = f"{found.error}{': ' + shown if shown else ''}"
            return listed("syntax", line=line, error=error, meaning=meaning(found))
        return None

    def exception_problem(self, output: str, path: Path, variant: Variant) -> Answer | None:
        """Return the exception that the program in the file `path` did not catch, or None."""
        found = crash(output, path)
        if found is None:
            return None
        shown = variant.text.split("\n")[found.line - 1].strip() if found.line else None
        place = f", in `{shown}`" if shown else ""
        if found.library_line:
            place += f" (raised in {found.library_line})"
        region = variant.region_of(found.line) if found.line else None
        texts = solution_text(self.file), variant.text
        parts = {region, *variant.judged} if region else {}
        nearby = [body(text, part) for text in texts for part in sorted(parts)]
        hint = meaning(found, "\n".join(nearby or texts))
        for todo in variant.judged if len(variant.judged) == 1 else ():
            hint = f"{hint} {in_full(hint_of(self._step(todo)).hint)}"
        expected, seen = f"{path.name} runs without an error", f"{found.error[:300]}{place}"
        return replace(mistake(expected, seen, hint, region), line=found.line)

    def written(self, text: str, todo: str) -> bool:
        """Return whether the student has begun with a region."""
        if regions(text)[todo].first == 0:
            return bool(body(text, todo).strip()) or "\n#!" in text
        return is_written(text, todo)

    def answers(self, steps: list, student: Student, stage: Stage) -> dict:
        """Return the answers to some steps of this file, by step id.

        Raises:
            FileError: Python or ROS cannot read the file
        """
        path, text = f"src/{self.file}", student.text(self.file)
        if text is None:
            return file_answers(steps, listed("missing_file", path, name=path, update=UPDATE))
        try:
            moved = set(regions(text)) - set(regions(solution_text(self.file)))
        except RegionError as error:
            return file_answers(steps, listed("todo_lines", path, error.line, error=error))
        if moved:
            answer = listed("other_version", path, number=min(moved), update=UPDATE)
            return file_answers(steps, answer)
        answers, begun = self._begun(steps, text)
        waits = self._waits(student) if begun else None
        if waits is not None:
            answers.update({step.id: waits for step in begun})
        elif begun:
            try:
                answers.update(self._judge(begun, text, stage))
            except NotBuilt as error:
                answer = listed("not_built", seen=error, build=BUILD)
                answers.update({step.id: answer for step in begun})
        return answers

    def _begun(self, steps: list, text: str) -> tuple:
        """Return the answers to steps without a student's line, and the other steps."""
        path, found = f"src/{self.file}", regions(text)
        answers, begun = {}, []
        for step in steps:
            if step.todo not in found:
                answers[step.id] = listed("no_todo", path, number=step.todo, update=UPDATE)
            elif not self.written(text, step.todo):
                region = found[step.todo]
                seen, hint = "nothing is written there yet", in_full(hint_of(step.id).hint)
                answers[step.id] = Answer(UNFINISHED, region.title, seen, hint, path, region.line)
            else:
                begun.append(step)
        return answers, begun

    def _waits(self, student: Student) -> Answer | None:
        """Return what must be built before the file can run, or None."""
        if not self.needs_build:
            return None
        for message in self.needs:
            built = student.built_md5(message)
            if built != solution_md5(message):
                hint = "`./workshop/check messages` reports what is missing."
                if (student.src / PACKAGE / "msg" / f"{message}.msg").is_file():
                    hint = f"{BUILD} {hint}"
                seen = (
                    "the message file has changed since the build" if built else "it is not built"
                )
                return listed("message_class", message=message, seen=seen, hint=hint)
        return None

    def _judge(self, steps: list, text: str, stage: Stage) -> dict:
        """Check the steps together; where that fails, each alone."""
        outside = self.syntax_problem(self._variant(text, ()))
        if outside is not None:
            return file_answers(steps, self._outside(text, outside))
        answers, sound = {}, []
        for step in steps:
            alone = self._variant(text, (step.todo,))
            refused = (found for found in self._typical(alone, step.todo) if found.expected)
            problem = self.syntax_problem(alone) or next(refused, None)
            if problem is not None:
                answers[step.id] = self._wrong(alone, step.todo, problem)
            else:
                sound.append(step)
        if not sound:
            return answers
        together = self._variant(text, tuple(step.todo for step in sound))
        found = self.problems(together, stage)
        if not found:
            return {**answers, **{step.id: Answer(PASSED) for step in sound}}
        for step in sound:
            variant = self._variant(text, (step.todo,))
            problems = found if len(sound) == 1 else self.problems(variant, stage)
            answers[step.id] = Answer(PASSED)
            if problems:
                answers[step.id] = self._blame(variant, step.todo, problems, text, stage)
        if all(answers[step.id].status == PASSED for step in sound):
            step = next((step for step in sound if step.todo == found[0].todo), sound[0])
            hint = listed("not_together", hint=found[0].hint).hint
            answers[step.id] = self._wrong(together, step.todo, replace(found[0], hint=hint))
        return answers

    def _variant(self, text: str, judged: tuple) -> Variant:
        return make(self.file, text, judged, self.left_empty)

    def _blame(self, variant: Variant, todo: str, found: list, text: str, stage: Stage) -> Answer:
        """Return the answer to the step that causes these problems."""
        if template(text) != template(solution_text(self.file)):
            outside = self.problems(self._variant(text, ()), stage)
            if outside:
                return self._outside(text, outside[0])
        own = next((problem for problem in found if problem.todo == todo), found[0])
        return self._wrong(variant, todo, own)

    def _wrong(self, variant: Variant, todo: str, problem: Answer) -> Answer:
        found = [known.hint for known in self._typical(variant, todo) if not known.expected]
        hint = " ".join([*found, problem.hint.replace(UNKNOWN, "") if found else problem.hint])
        line = variant.student_line(problem.line, todo)
        return replace(problem, hint=hint.strip(), file=f"src/{self.file}", line=line)

    def _typical(self, variant: Variant, todo: str) -> list:
        """Return what typical.yaml knows about a region of a Python file; see typical.mistakes."""
        if not self.file.endswith(".py"):
            return []
        right, region = body(solution_text(self.file), todo), regions(variant.text)[todo]
        return typical.mistakes(body(variant.text, todo), region, right)

    def _step(self, todo: str) -> str:
        return next(step.id for step in all_steps() if (step.file, step.todo) == (self.file, todo))

    def _outside(self, text: str, problem: Answer) -> Answer:
        changed = self._changed_line(text)
        near = f", near line {changed or problem.line}" if changed or problem.line else ""
        hint = (
            f"The error is outside of your TODOs{near}: a given line was changed. {UPDATE} "
            f"restores it, and keeps your TODOs. {problem.hint}"
        )
        return replace(problem, hint=hint, file=f"src/{self.file}", line=changed)

    def _changed_line(self, text: str) -> int | None:
        """Return the first line outside of all regions that differs from the template, from 1."""
        given = template(solution_text(self.file))
        for (index, line), (_, original) in zip(_outside_lines(text), _outside_lines(given)):
            if line != original:
                return index + 1
        return None


def _outside_lines(text: str) -> list:
    """Return (index, line) of the lines outside of all regions."""
    inside = {line for region in regions(text).values() for line in range(region.first, region.end)}
    return [(index, line) for index, line in enumerate(text.split("\n")) if index not in inside]


def solution_md5(message: str) -> str | None:
    """Return the md5 sum of a message of the solution."""
    return Student(PROJECT / "catkin_ws").built_md5(message)
