"""Steering methods are found by name; a mistake in the configuration is named with its fix."""

import math
import os

import pytest
import yaml

from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles
from sdc_package.steering.loader import load_steering, section_of

HERE = os.path.dirname(os.path.abspath(__file__))
with open(
    os.path.join(HERE, "..", "config", "simple_controller.yaml"), encoding="utf-8"
) as config_file:
    CONFIG = yaml.safe_load(config_file)
AXLES = Axles(**CONFIG["axles"])


@pytest.fixture()
def own_modules(tmp_path, monkeypatch):
    """Put two modules of students, and two that cannot be loaded, on Python's path."""
    (tmp_path / "needs_more.py").write_text(
        "import a_package_that_does_not_exist\n", encoding="utf-8"
    )
    (tmp_path / "takes_any.py").write_text(
        "class AnySteering:\n"
        "    def __init__(self, axles, **parameters):\n"
        "        self.gain = 2.0 * parameters['gain']\n"
        "    def wheel_angle(self, path, x, y, yaw, speed, yaw_rate=0.0):\n"
        "        return self.gain\n",
        encoding="utf-8",
    )
    (tmp_path / "misspelt.py").write_text("def wheel_angle(:\n", encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.syspath_prepend(os.path.join(HERE, "own_steering"))


@pytest.mark.usefixtures("own_modules")
def test_method_of_a_users_own_module_is_built():
    steering = load_steering("my_module:MySteering", {"gain": 0.2}, AXLES)
    path = ReferencePath()
    path.update([(0.0, 0.0, 5.0), (9.0, 0.0, 5.0)])
    assert steering.wheel_angle(path, 0.0, 1.0, 0.0, 5.0) == pytest.approx(-0.2)
    assert section_of("my_module:MySteering") == "MySteering"
    assert section_of("lqr") == "lqr"


@pytest.mark.usefixtures("own_modules")
def test_method_may_take_any_parameter():
    steering = load_steering("takes_any:AnySteering", {"gain": 0.2, "other": "text"}, AXLES)
    assert steering.wheel_angle(ReferencePath(), 0.0, 0.0, 0.0, 5.0) == 0.4


@pytest.mark.usefixtures("own_modules")
@pytest.mark.parametrize(
    ("method", "parameters", "part"),
    [
        ("stanly", {}, "no steering_method 'stanly': did you mean 'stanley'"),
        ("kin", {}, "no steering_method 'kin': did you mean 'kinematic'"),
        ("xyz", {}, "no steering_method 'xyz'; write one of stanley, stanley_compensated, pure"),
        ("", {}, "must be one of stanley, stanley_compensated, pure_pursuit"),
        (5, {}, "must be one of"),
        ("stanley:", {}, "form my_module:MySteering"),
        (
            "your_module:YourSteering",
            {},
            "no module 'your_module'; put the folder of your_module.py on the PYTHONPATH",
        ),
        (
            "needs_more:MySteering",
            {},
            "steering_method 'needs_more:MySteering': module 'needs_more' imports "
            "'a_package_that_does_not_exist', which is not installed",
        ),
        ("misspelt:MySteering", {}, "cannot be loaded"),
        ("my_module:MySteerin", {}, "no class 'MySteerin': did you mean 'MySteering'"),
        ("my_module:Steerin", {}, "no class 'Steerin': did you mean 'MySteering'"),
        (
            "takes_any:AnySteering",
            {"gain": None},
            "steering_method 'takes_any:AnySteering' cannot be built from section 'AnySteering': ",
        ),
        ("my_module:NoSteering", {}, "is not a class with a method wheel_angle"),
        ("my_module:MySteering", None, "section 'MySteering' lacks 'gain'"),
        (
            "my_module:MySteering",
            {"gain": 1.0, "gian": 1.0},
            "has 'gian', which is no parameter of steering_method 'my_module:MySteering': did you "
            "mean 'gain'",
        ),
        ("pure_pursuit", None, "section 'pure_pursuit' lacks 'look_ahead_s'"),
        ("stanley", 3.0, "must hold lines"),
        (
            "stanley",
            {**CONFIG["stanley"], "k": -1.0},
            "section 'stanley': k must be a positive number, got -1.0",
        ),
        ("stanley", {**CONFIG["stanley"], "k": "fast"}, "k must be a positive number, got 'fast'"),
        (
            "stanley_compensated",
            {**CONFIG["stanley_compensated"], "preview_s": math.nan},
            "section 'stanley_compensated': preview_s",
        ),
        ("stanley", {**CONFIG["stanley"], "preview_s": 0.0}, "has 'preview_s', which is no"),
        (
            "pure_pursuit",
            {**CONFIG["pure_pursuit"], "shortest_look_ahead_m": 20.0},
            "exceeds longest_look_ahead_m",
        ),
        ("kinematic", {**CONFIG["kinematic"], "convergence_m": 0.0}, "convergence_m"),
        ("lqr", {**CONFIG["lqr"], "steer_weight": 0.0}, "steer_weight"),
    ],
)
def test_method_that_cannot_be_built_is_refused_in_one_line(method, parameters, part):
    with pytest.raises(ValueError, match="") as caught:
        load_steering(method, parameters, AXLES)
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)


def test_lqr_refuses_rigid_tyres():
    with pytest.raises(ValueError, match="front_compliance"):
        load_steering("lqr", CONFIG["lqr"], Axles(1.0, 1.0, 0.0, 0.0))
