"""The functions of the page of the lab are right, and typical mistakes are named."""

import re
import runpy
from pathlib import Path

import numpy as np
import pytest
import yaml

pytest.importorskip("torch", reason="torch is not installed (docker/prepare imitation)")

from sdc_perception.imitation.check import problems
from sdc_perception.imitation.samples import Samples
from sdc_perception.imitation.train import train

PAGE = Path(__file__).resolve().parents[5] / "docs" / "labs" / "imitation.md"
NAMES = ("balance", "loss", "layer", "closed_loop")
MISTAKES = yaml.safe_load(Path(__file__).with_name("imitation_mistakes.yaml").read_text())


def lesson(tmp_path, old="", new=""):
    text = "\n\n".join(re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S))
    assert old in text
    (tmp_path / "lesson.py").write_text(text.replace(old, new) if old else text)
    return runpy.run_path(str(tmp_path / "lesson.py"))


def test_functions_of_the_page_are_right(tmp_path):
    assert problems(lesson(tmp_path)) == dict.fromkeys(NAMES, "")
    assert set(problems({}).values()) == {"is not written yet"}


@pytest.mark.parametrize("row", MISTAKES, ids=lambda row: row["says"])
def test_typical_mistake_is_named(tmp_path, row):
    found = problems(lesson(tmp_path, row["old"], row["new"]))
    assert row["says"] in found.pop(row["name"])
    assert set(found.values()) == {""}


def test_network_is_trained_with_the_balance_and_the_loss_of_a_student(tmp_path):
    random, used, seen = np.random.default_rng(0), lesson(tmp_path), []
    views = random.integers(0, 255, (256, 40, 128, 3), dtype=np.uint8)
    answers = np.column_stack([random.normal(0.0, 0.05, 256), np.full(256, 6.0)])
    used["loss"] = lambda answers, targets: seen.append(1) or (answers - targets).abs().mean()
    train(Samples(views, answers, np.zeros(256, bool)), 3, lesson=used)
    assert len(seen) == 3
