"""Steering methods are found by name; a mistake in the configuration is named with its fix."""

import os
import subprocess
import sys

import pytest

from sdc_common.configuration import node_config
from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles
from sdc_package.steering.loader import load_steering, section_of

HERE = os.path.dirname(os.path.abspath(__file__))
CONFIG = node_config("sdc_package", "simple_controller")
AXLES = Axles(**CONFIG["axles"])


@pytest.fixture()
def own_modules(tmp_path, monkeypatch):
    """Put a module of a student, and two that cannot be loaded, on Python's path."""
    (tmp_path / "needs_more.py").write_text(
        "import a_package_that_does_not_exist\n", encoding="utf-8"
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
@pytest.mark.parametrize(
    ("method", "parameters", "part"),
    [
        ("stanly", {}, "no steering_method 'stanly': did you mean 'stanley'"),
        ("xyz", {}, "no steering_method 'xyz': write one of stanley, stanley_compensated, pure"),
        ("", {}, "write one of stanley, stanley_compensated, pure_pursuit"),
        (5, {}, "write one of"),
        (
            "your_module:YourSteering",
            {},
            "No module named 'your_module'; the folder of your_module.py must be on the PYTHONPATH",
        ),
        ("needs_more:MySteering", {}, "No module named 'a_package_that_does_not_exist'"),
        ("misspelt:MySteering", {}, "cannot be loaded"),
        ("my_module:MySteerin", {}, "no attribute 'MySteerin'"),
        ("my_module:NoSteering", {}, "is not a class with a method wheel_angle"),
        ("my_module:MySteering", None, "section 'MySteering' does not fit"),
        ("my_module:MySteering", {"gain": 1.0, "gian": 1.0}, "unexpected keyword argument 'gian'"),
        ("pure_pursuit", None, "'look_ahead_s'"),
        ("stanley", 3.0, "section 'stanley' does not fit"),
        (
            "stanley",
            {**CONFIG["stanley"], "k": -1.0},
            "section 'stanley': k must be a positive number, got -1.0",
        ),
        ("stanley", {**CONFIG["stanley"], "k": "fast"}, "k must be a positive number, got 'fast'"),
        ("lqr", {**CONFIG["lqr"], "steer_weight": 0.0}, "steer_weight"),
    ],
)
def test_method_that_cannot_be_built_is_refused_in_one_line(method, parameters, part):
    with pytest.raises(ValueError, match="") as caught:
        load_steering(method, parameters, AXLES)
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)


def test_method_of_a_lab_that_is_not_in_the_workspace_names_the_command_that_adds_it():
    program = (
        "from sdc_package.steering.axles import Axles\n"
        "from sdc_package.steering.loader import load_steering\n"
        "try:\n"
        "    load_steering('mpc', {}, Axles(1.4, 1.4, 0.01, 0.01))\n"
        "except ValueError as error:\n"
        "    print(error)\n"
    )
    packages = [
        os.path.join(HERE, "..", "..", name, "src") for name in ("sdc_common", "sdc_package")
    ]
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(packages)},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    assert done.stdout == (
        "steering_method 'mpc' cannot be loaded: No module named 'sdc_mpc'; "
        "./workshop/start --lab mpc DIR in the folder of the project adds it to the workspace DIR\n"
    )


def test_lqr_refuses_rigid_tyres():
    with pytest.raises(ValueError, match="front_compliance"):
        load_steering("lqr", CONFIG["lqr"], Axles(1.0, 1.0, 0.0, 0.0))
