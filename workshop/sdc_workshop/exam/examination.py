"""Check the steps of a workspace, in their order."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from functools import lru_cache
from typing import Callable

import yaml

from sdc_workshop.exam.answer import PASSED, WRONG, Answer, encodable, in_full, listed, mistake
from sdc_workshop.exam.camera_check import CameraCheck
from sdc_workshop.exam.controller_checks import BasicControlCheck, PathFollowingCheck
from sdc_workshop.exam.drive_answer import drive_answer
from sdc_workshop.exam.experiment import Experiment
from sdc_workshop.exam.file_check import FileCheck, message_answer
from sdc_workshop.exam.files import hello_answer, workspace_answer
from sdc_workshop.exam.library_check import LibraryCheck
from sdc_workshop.exam.planner_checks import LocalPlannerCheck, MissionPlannerCheck
from sdc_workshop.exam.process import NotJudged
from sdc_workshop.exam.region_check import RegionCheck, file_answers
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.regions import RegionError
from sdc_workshop.steps import LABS, WORKSHOP, Step, hint_of, lesson_folder, load_steps
from sdc_workshop.student_file import FileError

_NODES = (
    CameraCheck,
    MissionPlannerCheck,
    LocalPlannerCheck,
    BasicControlCheck,
    PathFollowingCheck,
)


@lru_cache(maxsize=None)
def _tables(lab: str) -> dict:
    return yaml.safe_load((lesson_folder(lab) / "checks.yaml").read_text(encoding="utf-8"))


@lru_cache(maxsize=1)
def checks() -> tuple:
    """Return the checks that the checks.yaml of the workshop and of each lab list."""
    found: list = []
    for lab in (WORKSHOP, *LABS):
        for file, table in _tables(lab).items():
            if file == "drive":
                continue
            nodes = [node(table) for node in _NODES if node.file == file]
            other = LibraryCheck if "rows" in table else FileCheck
            found += nodes or [other(file, table)]
    return tuple(found)


# A car drives without its camera, and without being installed.
_NOT_FOR_THE_DRIVE = ("hello", "camera", "install")


def check_of(step: Step) -> RegionCheck | None:
    """Return what checks a step, or None for a step without a region."""
    return next((one for one in checks() if one.file == step.file and step.todo in one.todos), None)


class Examination:
    """Checks steps of a student, and keeps their answers by step id.

    `report` is the referee's of the last step, or None. With `drive_anyway`, the car also drives
    when some steps are wrong.
    """

    def __init__(self, student: Student, stage: Stage, drive_anyway: bool = False):
        self.student = student
        self.stage = stage
        self.answers: dict = {}
        self.report: dict | None = None
        self.drive_anyway = drive_anyway

    def judge(
        self,
        steps: list,
        on_answer: Callable[[Step, Answer], object] = lambda step, answer: None,
        stop_at_first: bool = False,
        on_begin: Callable[[Step, str], object] = lambda step, waits_for: None,
    ) -> dict:
        """Check some steps, and return the answers by step id.

        Steps of one file are checked together, where possible in one run.

        Args:
            steps: the steps
            on_answer: called with each step and its answer, in order, as soon as it is known
            stop_at_first: stop after the first step that is not passed
            on_begin: called with each step before it is checked, and what takes long, for people
        """
        reported = 0
        for step in steps:
            if step.id not in self.answers:
                check = check_of(step)
                drives = "the car drives the whole route" if step.id.endswith("drive") else ""
                on_begin(step, check.waits_for if check is not None else drives)
                for step_id, answer in self._checked(step, steps).items():
                    seed = self.stage.seed if answer.status == WRONG else ""
                    self.answers[step_id] = replace(encodable(answer), seed=seed)
            while reported < len(steps) and steps[reported].id in self.answers:
                answer = self.answers[steps[reported].id]
                on_answer(steps[reported], answer)
                reported += 1
                if stop_at_first and answer.status != PASSED:
                    return {other.id: self.answers[other.id] for other in steps[:reported]}
        return {step.id: self.answers[step.id] for step in steps}

    def _checked(self, step: Step, steps: list) -> dict:
        """Return the answers to a step and to the other steps of its file."""
        check, together = check_of(step), [step]
        if check is not None:
            together = [other for other in steps if check_of(other) is check]
        try:
            for _ in range(2):
                with contextlib.suppress(NotJudged):
                    if check is not None:
                        return check.answers(together, self.student, self.stage)
                    return {step.id: self._without_region(step)}
            return {other.id: listed("not_judged") for other in together}
        except FileError as error:
            problem = mistake("a text file in UTF-8 that is complete", error.seen, error.fix)
            place = {"file": f"src/{step.file}", "line": error.line}
            return file_answers(together, replace(problem, **place))
        except Exception as error:
            if self.stage.sandbox is None:
                raise
            # What a strange program returns may raise anything; the other steps are checked.
            answer = Answer(WRONG, "a result that can be read", f"{type(error).__name__}: {error}")
            self.stage.report(f"{step.id} could not be checked: {answer.seen[:300]}")
            return {other.id: answer for other in together}

    def _drive(self, drive: Step) -> Answer:
        lesson = load_steps(drive.lab)
        before = lesson[: lesson.index(drive)]
        steps = [step for step in before if not step.id.startswith(_NOT_FOR_THE_DRIVE)]
        unwritten = [step.id for step in steps if not self._is_written(step)]
        if unwritten:
            more = " and more" if len(unwritten) > 3 else ""
            return listed("unwritten_steps", names=", ".join(unwritten[:3]) + more)
        wrong = [
            step.id
            for step in steps
            if step.id in self.answers and self.answers[step.id].status != PASSED
        ]
        if wrong and not self.drive_anyway:
            return listed("wrong_steps", names=", ".join(wrong), drive=drive.id)
        answer, self.report = drive_answer(self.stage, _tables(drive.lab)["drive"])
        return answer

    def drive_unknown(self, lab: str) -> None:
        """Drive on another road than the first one; see drive_answer."""
        drive_answer(self.stage, _tables(lab)["drive"], second=True)

    def _is_written(self, step: Step) -> bool:
        if step.file is None:
            return True
        check = check_of(step)
        try:
            text = self.student.text(step.file)
            if text is None or check is None:
                return bool(text)
            return check.written(text, str(step.todo))
        except (RegionError, KeyError):
            return True

    def _without_region(self, step: Step) -> Answer:
        if step.id.endswith("workspace"):
            return workspace_answer(self.student, self.stage)
        if step.id == "hello":
            return hello_answer(self.student, self.stage)
        if step.id.endswith("drive"):
            return self._drive(step)
        if step.id.startswith("experiment-"):
            return Experiment.named(step.id, self.student.folder).answer()
        name = str(step.file).rpartition("/")[2].partition(".")[0]
        return message_answer(name, in_full(hint_of(step.id).hint), self.student)
