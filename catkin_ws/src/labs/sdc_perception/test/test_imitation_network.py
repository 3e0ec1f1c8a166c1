"""The network and the functions of the page of the lab; typical mistakes are named."""

import pickle
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
from sdc_perception.imitation_network import SteeringNetwork, build_network

VIEW = np.random.default_rng(0).integers(0, 255, (40, 128, 3), dtype=np.uint8)


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "network.npz"
    network = SteeringNetwork(build_network())
    network.save(str(path))
    return network, path


def test_loaded_network_answers_as_the_saved_one(saved):
    network, path = saved
    assert SteeringNetwork.load(str(path)).answer(VIEW) == network.answer(VIEW)
    other = VIEW.copy()
    other[:, 60:] = 0
    assert network.answer(other) != network.answer(VIEW)


class Boom:
    def __reduce__(self):
        return exec, ("raise SystemExit('the file ran code')",)


def changed(path, **changes):
    with np.load(path) as file:
        entries = {**file, **changes}
    with open(path, "wb") as file:
        np.savez(file, **{name: value for name, value in entries.items() if value is not None})


@pytest.mark.parametrize(
    ("damage", "problem"),
    [
        (lambda path: path.unlink(), "there is no such file"),
        (lambda path: path.write_bytes(b""), "is not a steering network"),
        (lambda path: path.write_text("hello"), "is not a steering network"),
        (lambda path: path.write_bytes(path.read_bytes()[:5000]), "is not a steering network"),
        (lambda path: path.write_bytes(pickle.dumps(Boom())), "is not a steering network"),
        (lambda path: changed(path, format=None), "no entry 'format'"),
        (lambda path: changed(path, format=np.array([Boom()])), "is not a steering network"),
        (lambda path: changed(path, **{"0.bias": None}), "the weights '0.bias' are missing"),
        (lambda path: changed(path, **{"0.bias": np.zeros(3, np.float32)}), "of another size"),
        (lambda path: changed(path, **{"0.bias": np.full(16, np.nan, np.float32)}), "not finite"),
    ],
)
def test_bad_file_is_refused_in_one_line(saved, damage, problem):
    _, path = saved
    damage(path)
    with pytest.raises(ValueError) as refused:
        SteeringNetwork.load(str(path))
    text = str(refused.value)
    assert text.startswith(f"{path}: ")
    assert problem in text
    assert "sdc_perception.imitation.train" in text
    assert "\n" not in text


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
