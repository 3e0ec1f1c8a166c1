"""Judges the steps of a workspace, in their order."""

from __future__ import annotations

from sdc_workshop.exam.answer import PASSED, UNFINISHED, WAITING, Answer
from sdc_workshop.exam.camera_subject import CameraSubject, LaneFilterSubject
from sdc_workshop.exam.cmake_subject import CMakeSubject, PackageXmlSubject
from sdc_workshop.exam.controller_subject import BasicControlSubject, PathFollowingSubject
from sdc_workshop.exam.drive_answer import drive_answer
from sdc_workshop.exam.files import hello_answer, message_answer, workspace_answer
from sdc_workshop.exam.hints import hint_of
from sdc_workshop.exam.launch_subject import IncludeSubject, NodeLaunchSubject
from sdc_workshop.exam.library_subjects import (
    OdometrySubject,
    PidSubject,
    StanleySubject,
    WaypointSearchSubject,
)
from sdc_workshop.exam.local_planner_subject import LocalPlannerSubject
from sdc_workshop.exam.mission_planner_subject import MissionPlannerSubject
from sdc_workshop.exam.student import Student
from sdc_workshop.regions import RegionError
from sdc_workshop.steps import Step, load_steps

SUBJECTS = (
    NodeLaunchSubject("hello", "hello.sh", []),
    CameraSubject(),
    LaneFilterSubject(),
    NodeLaunchSubject("camera", "camera.py", ["headless:=true"], ["headless:=false"]),
    PackageXmlSubject(),
    CMakeSubject(),
    BasicControlSubject(),
    PathFollowingSubject(),
    NodeLaunchSubject(
        "simple_controller",
        "simple_controller.py",
        [],
        ["basic_control:=true", "steering_method:=pure_pursuit"],
    ),
    IncludeSubject("stack", "1", "2"),
    IncludeSubject("all", "1"),
    MissionPlannerSubject(),
    NodeLaunchSubject(
        "mission_planner",
        "mission_planner.py",
        ["waypoints_path:=/tmp/route.csv"],
        ["waypoints_path:=mine/route.csv"],
    ),
    LocalPlannerSubject(),
    WaypointSearchSubject(),
    NodeLaunchSubject(
        "local_planner",
        "local_planner.py",
        [],
        ["planned_speed_mps:=7.5", "planner_options:={lookahead_m: 33.0}"],
    ),
    OdometrySubject(),
    PidSubject(),
    StanleySubject(),
)


def subject_of(step: Step):
    """Who judges a step; None for a step without a region."""
    return next(
        (
            subject
            for subject in SUBJECTS
            if subject.file == step.file and step.todo in subject.todos
        ),
        None,
    )


# A car drives without its camera, and without being installed.
_NOT_FOR_THE_DRIVE = ("hello", "camera", "install")


class Examination:
    """Judges steps, and keeps the answers. `report` is what the referee wrote, once the last step has been judged; with `drive_anyway`
    a car drives whose steps are written, but not all right."""

    def __init__(self, student: Student, stage, drive_anyway: bool = False):
        self.student = student
        self.stage = stage
        self.answers = {}
        self.report = None
        self.drive_anyway = drive_anyway

    def judge(
        self, steps: list, told=lambda step, answer: None, stop_at_first: bool = False
    ) -> dict:
        """{id: Answer} of some steps; `told` is called with each as soon as its answer and those before it are known. Steps of one file
        are judged together, from one start of its node where that can be. With `stop_at_first` the first that is not passed is the last."""
        told_until = 0
        for step in steps:
            if step.id not in self.answers:
                subject = subject_of(step)
                if subject is None:
                    self.answers[step.id] = self._without_region(step)
                else:
                    together = [other for other in steps if subject_of(other) is subject]
                    self.answers.update(subject.answers(together, self.student, self.stage))
            while told_until < len(steps) and steps[told_until].id in self.answers:
                told(steps[told_until], self.answers[steps[told_until].id])
                told_until += 1
                if stop_at_first and self.answers[steps[told_until - 1].id].status != PASSED:
                    return {other.id: self.answers[other.id] for other in steps[:told_until]}
        return {step.id: self.answers[step.id] for step in steps}

    def _drive(self) -> Answer:
        steps = [
            step
            for step in load_steps()
            if step.id != "drive" and not step.id.startswith(_NOT_FOR_THE_DRIVE)
        ]
        unwritten = [step.id for step in steps if not self._is_written(step)]
        if unwritten:
            more = " and more" if len(unwritten) > 3 else ""
            return Answer(
                UNFINISHED,
                "a car that is written",
                f"nothing is written yet at {', '.join(unwritten[:3])}{more}",
                "The drive comes when all is written.",
            )
        wrong = [
            step.id
            for step in steps
            if step.id in self.answers and self.answers[step.id].status != PASSED
        ]
        if wrong and not self.drive_anyway:
            return Answer(
                WAITING,
                "a car in which all steps are right",
                f"not right yet: {', '.join(wrong)}",
                "The drive comes when all is right; `./workshop/check drive` drives all the same.",
            )
        answer, self.report = drive_answer(self.stage)
        return answer

    def _is_written(self, step: Step) -> bool:
        if step.file is None:
            return True
        text = self.student.text(step.file)
        subject = subject_of(step)
        if text is None or subject is None:
            return bool(text)
        try:
            return subject.written(text, step.todo)
        except (RegionError, KeyError):
            return True

    def _without_region(self, step: Step) -> Answer:
        if step.id == "workspace":
            return workspace_answer(self.student, self.stage)
        if step.id == "hello":
            return hello_answer(self.student, self.stage)
        if step.id == "drive":
            return self._drive()
        return message_answer(
            step.file.rpartition("/")[2].partition(".")[0], hint_of(step.id).hint, self.student
        )
