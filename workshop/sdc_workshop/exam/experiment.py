"""An experiment of phase 4: a prediction, a drive with one changed setting, and what it shows."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import yaml

from sdc_workshop.exam.answer import PASSED, Answer, answered
from sdc_workshop.steps import FOLDER
from sdc_workshop.student_file import read_anyway, values

PREDICTIONS = "predictions.yaml"
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


@dataclass(frozen=True)
class Experiment:
    """One row of experiments.yaml in a student's workspace."""

    id: str
    folder: Path
    setting: str
    done: str
    metric: str
    question: str
    choices: dict
    results: dict
    why: str

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
            return answered(
                "no_prediction", id=self.id, seen=prediction or "none", question=self.question,
                choices=choices,
            )  # fmt: skip
        reports = [_read(self.folder / name) for name in (_BASE, report_name)]
        for name, report in zip((_BASE, report_name), reports):
            if self.metric not in report:
                return answered("no_experiment", report=name, setting=self.setting)
        old, new = (report[self.metric] for report in reports)
        names = {"old": old, "new": new, "status": reports[1]["status"], "at": self._parameter}
        if not self._is(self.done, names):
            return answered("same_setting", report=report_name, setting=self.setting)
        result = next(key for key, when in self.results.items() if self._is(when, names))
        right = "As predicted." if result == prediction else "Not as predicted."
        return Answer(
            PASSED,
            f"{prediction}: {self.choices[prediction]}",
            f"{result}: {self.choices[result]}. {self.metric} is {new:.3g} in {report_name}, "
            f"{old:.3g} in {_BASE}.",
            f"{right} {self.why}",
        )

    def _parameter(self, name: str) -> object:
        """Return a parameter of the drive by its full name, "" without one."""
        found: object = _read(self.folder / f"report/{self.id}.parameters.json")
        for part in name.split("/"):
            found = found.get(part, "") if isinstance(found, dict) else ""
        return found

    @staticmethod
    def _is(condition: str, names: dict) -> bool:
        """Return whether a condition of experiments.yaml, which students do not write, is true."""
        return bool(eval(condition, {"__builtins__": {}}, names))  # noqa: S307
