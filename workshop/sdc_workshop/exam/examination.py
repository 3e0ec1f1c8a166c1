"""Judges the steps of a workspace, in their order."""
from __future__ import annotations

from sdc_workshop.exam.answer import Answer
from sdc_workshop.exam.camera_subject import CameraSubject, LaneFilterSubject
from sdc_workshop.exam.cmake_subject import CMakeSubject, PackageXmlSubject
from sdc_workshop.exam.controller_subject import BasicControlSubject, PathFollowingSubject
from sdc_workshop.exam.drive_answer import drive_answer
from sdc_workshop.exam.files import hello_answer, message_answer, workspace_answer
from sdc_workshop.exam.launch_subject import IncludeSubject, NodeLaunchSubject
from sdc_workshop.exam.library_subjects import OdometrySubject, PidSubject, StanleySubject, WaypointSearchSubject
from sdc_workshop.exam.local_planner_subject import LocalPlannerSubject
from sdc_workshop.exam.mission_planner_subject import MissionPlannerSubject
from sdc_workshop.exam.student import Student
from sdc_workshop.steps import Step

SUBJECTS = (
    NodeLaunchSubject("hello", "hello.sh", []),
    CameraSubject(), LaneFilterSubject(),
    NodeLaunchSubject("camera", "camera.py", ["headless:=true"], ["headless:=false"]),
    PackageXmlSubject(), CMakeSubject(),
    BasicControlSubject(), PathFollowingSubject(),
    NodeLaunchSubject("simple_controller", "simple_controller.py", [], ["basic_control:=true", "steering_method:=pure_pursuit"]),
    IncludeSubject("stack", "1", "2"), IncludeSubject("all", "1"),
    MissionPlannerSubject(),
    NodeLaunchSubject("mission_planner", "mission_planner.py", ["waypoints_path:=/tmp/route.csv"], ["waypoints_path:=mine/route.csv"]),
    LocalPlannerSubject(), WaypointSearchSubject(),
    NodeLaunchSubject("local_planner", "local_planner.py", [], ["planned_speed_mps:=7.5", "planner_options:={lookahead_m: 33.0}"]),
    OdometrySubject(), PidSubject(), StanleySubject())


def subject_of(step: Step):
    """Who judges a step; None for a step without a region."""
    return next((subject for subject in SUBJECTS if subject.file == step.file and step.todo in subject.todos), None)


class Examination:
    """Judges steps, and keeps the answers. `report` is what the referee wrote, once the last step has been judged."""

    def __init__(self, student: Student, stage):
        self.student = student
        self.stage = stage
        self.answers = {}
        self.report = None

    def judge(self, steps: list, told=lambda step, answer: None) -> dict:
        """{id: Answer} of some steps; `told` is called with each as soon as its answer and those before it are known. Steps of one file
        are judged together, from one start of its node where that can be."""
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
        return {step.id: self.answers[step.id] for step in steps}

    def _without_region(self, step: Step) -> Answer:
        if step.id == "workspace":
            return workspace_answer(self.student, self.stage)
        if step.id == "hello":
            return hello_answer(self.student, self.stage)
        if step.id == "drive":
            answer, self.report = drive_answer(self.student, self.stage)
            return answer
        return message_answer(step.file.rpartition("/")[2].partition(".")[0], self.student, self.stage)
