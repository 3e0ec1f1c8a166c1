"""The functions of the page of the lab are right, and typical mistakes are named."""

import re
import runpy
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("torch", reason="torch is not installed (docker/prepare imitation)")

from sdc_perception.imitation.check import problems
from sdc_perception.imitation.samples import Samples
from sdc_perception.imitation.train import train

PAGE = Path(__file__).resolve().parents[5] / "docs" / "labs" / "imitation.md"
NAMES = ("balance", "loss", "layer", "closed_loop")
MISTAKES = [
    ("balance", "rare / rare.sum()", "rare", "their sum is 2"),
    ("balance", "1.0 / np.bincount(bins)[bins]", "1.0 * np.bincount(bins)[bins]", "frequent bin"),
    (
        "balance",
        "np.digitize(curvatures_1pm",
        "np.digitize(abs(curvatures_1pm)",
        "sign of the curv",
    ),
    ("loss", "0.5 * error**2", "error**2", "half is missing"),
    ("loss", "error < 1.0", "error < 9.0", "squared"),
    ("layer", "np.maximum(out, 0.0)", "out", "ReLU"),
    ("layer", "kernel * view", "kernel[::-1, ::-1] * view", "turned around"),
    ("closed_loop", "STEP_M * steer", "steer", "multiply it by STEP_M"),
    ("closed_loop", "steer(offset_m, ", "steer(offsets[0], ", "where the car is then"),
    ("closed_loop", "offsets = [offset_m]", "offsets = []", "at the start is missing"),
]


def lesson(tmp_path, old="", new=""):
    text = "\n\n".join(re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S))
    assert old in text
    (tmp_path / "lesson.py").write_text(text.replace(old, new) if old else text)
    return runpy.run_path(str(tmp_path / "lesson.py"))


def test_functions_of_the_page_are_right(tmp_path):
    assert problems(lesson(tmp_path)) == dict.fromkeys(NAMES, "")
    assert set(problems({}).values()) == {"is not written yet"}


@pytest.mark.parametrize(("name", "old", "new", "says"), MISTAKES)
def test_typical_mistake_is_named(tmp_path, name, old, new, says):
    found = problems(lesson(tmp_path, old, new))
    assert says in found.pop(name)
    assert set(found.values()) == {""}


def test_network_is_trained_with_the_balance_and_the_loss_of_a_student(tmp_path):
    random, used, seen = np.random.default_rng(0), lesson(tmp_path), []
    views = random.integers(0, 255, (256, 40, 128, 3), dtype=np.uint8)
    answers = np.column_stack([random.normal(0.0, 0.05, 256), np.full(256, 6.0)])
    used["loss"] = lambda answers, targets: seen.append(1) or (answers - targets).abs().mean()
    train(Samples(views, answers, np.zeros(256, bool)), 3, lesson=used)
    assert len(seen) == 3
