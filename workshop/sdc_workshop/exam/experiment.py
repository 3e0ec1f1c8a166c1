"""An experiment of phase 4: a prediction, a drive with one changed setting, and what it shows."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import yaml

from sdc_workshop.exam.answer import PASSED, Answer, listed
from sdc_workshop.steps import FOLDER
from sdc_workshop.student_file import read_anyway, values

PREDICTIONS = "predictions.yaml"
# Parameters that differ in each drive.
_OF_A_DRIVE = ("/report", "/picture_feed", "/drive_log")
_BASE = "report/my_route.json"


@lru_cache(maxsize=1)
def table() -> dict:
    """Return the rows of experiments.yaml by the id of their step."""
    return yaml.safe_load((FOLDER / "experiments.yaml").read_text(encoding="utf-8"))


def _read(path: Path) -> dict:
    """Return the content of a file of YAML or JSON; {} where it is none."""
    with contextlib.suppress(OSError):
        return values(read_anyway(path))
    return {}


def _parameters(path: Path) -> dict:
    """Return the parameters of a drive by NODE/PARAMETER; of a path, the name of its file."""
    found, queue = {}, list(_read(path).items())
    for name, value in queue:
        if isinstance(value, dict):
            queue += [(f"{name}/{key}", inner) for key, inner in value.items()]
        elif "/" in name and not name.startswith("roslaunch") and not name.endswith(_OF_A_DRIVE):
            found[name] = Path(value).name if isinstance(value, str) else value
    return found


def _place(name: str) -> str:
    """Return where a parameter is set, for people."""
    node = name.split("/")[0]
    is_world = node in ("sim", "referee") or name.endswith("_path")
    return "in the command of the drive" if is_world else f"in config/{node}.yaml"


@dataclass(frozen=True)
class Experiment:
    """One row of experiments.yaml in a student's workspace."""

    id: str
    folder: Path
    setting: str
    metric: str
    question: str
    choices: dict
    results: dict
    why: str
    changes: dict = field(default_factory=dict)
    done: str = "True"

    @staticmethod
    def named(step_id: str, folder: Path) -> Experiment:
        """Return the experiment of a step in the workspace `folder`."""
        return Experiment(step_id, folder, **table()[step_id])

    def answer(self) -> Answer:
        """Return what is missing; with a prediction and a drive, the result of the experiment.

        A wrong prediction passes: the answer explains it.
        """
        report_name = f"report/{self.id}.json"
        prediction = str(_read(self.folder / PREDICTIONS).get(self.id, "")).lower()
        if prediction not in self.choices:
            choices = "  ".join(f"{key}: {text}." for key, text in self.choices.items())
            texts = {"question": self.question, "choices": choices}
            return listed("no_prediction", id=self.id, seen=prediction or "no such line", **texts)
        reports = [_read(self.folder / name) for name in (_BASE, report_name)]
        for name, report in zip((_BASE, report_name), reports):
            if self.metric not in report:
                return listed("no_experiment", report=name, setting=self.setting)
        old, new = (report[self.metric] for report in reports)
        names = {**reports[1], "old": old, "new": new}
        difference = self._difference(report_name)
        if difference is not None:
            return difference
        if not self._is(self.done, names):
            return listed("same_drive", report=report_name, setting=self.setting)
        result = next(key for key, when in self.results.items() if self._is(when, names))
        right = "As predicted." if result == prediction else "Not as predicted."
        return Answer(
            PASSED,
            f"{prediction}: {self.choices[prediction]}",
            f"{result}: {self.choices[result]}. {self.metric} is {new:.3g} in {report_name}, "
            f"{old:.3g} in {_BASE}.",
            f"{right} {self.why}",
        )

    def _difference(self, report: str) -> Answer | None:
        """Return which parameter of the drive is not the one that is asked for, or None."""
        base, drive = (
            _parameters(self.folder / Path(name).with_suffix(".parameters.json"))
            for name in (_BASE, report)
        )
        for name, wanted in {**self.changes, **base, **self.changes}.items():
            got = drive.get(name, "not set")
            if got == wanted:
                continue
            node, _, key = name.rpartition("/")
            texts = {"report": report, "name": name, "wanted": wanted, "got": got, "base": _BASE}
            if name not in self.changes:
                return listed("another_parameter", place=_place(name), **texts)
            others = [
                other
                for other, value in drive.items()
                if value == wanted and base.get(other) != value and other.endswith(f"/{key}")
            ]
            note = f"{others[0]} is {wanted}: it must be in {node}. " if others else ""
            place = _place(name)
            return listed("same_setting", setting=self.setting, note=note, place=place, **texts)
        return None

    @staticmethod
    def _is(condition: str, names: dict) -> bool:
        """Return whether a condition of experiments.yaml, which students do not write, is true."""
        return bool(eval(condition, {"__builtins__": {}}, names))  # noqa: S307
