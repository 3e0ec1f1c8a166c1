"""The library without ROS: from its sources, and from the wheel."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ROOT / "catkin_ws" / "src"
SOURCES = [*PACKAGES.glob("*/src"), *PACKAGES.glob("labs/*/src"), ROOT / ".venv" / "packages"]
VENV = ROOT / ".wheel"
needs_wheel = pytest.mark.skipif(
    not (VENV / "bin/sdc").exists(),
    reason="docker/prepare wheel, which needs a connection: not run",
)
MAX_WHEEL = 3 << 20  # bytes
# Of the same drive with another version of NumPy [m, rad, m/s]. Commands are rounded to float32: in
# a long drive, the last bit of one of them can differ.
TOLERANCES = {"slalom": 1e-9, "lights": 1e-9, "noise": 1e-9, "town": 1e-6}

# Modules of ROS and of Linux, and names of the standard library that Linux alone has.
HIDE = """
import os, signal, socket, sys

sys.modules.update(dict.fromkeys(["fcntl", "resource", "grp", "pwd", "termios", "seccomp"]))
sys.modules.update(dict.fromkeys(["rospkg", "rospy", "rosgraph", "roslib", "genpy", "catkin"]))
for module, names in (
    (os, ["sched_getaffinity", "geteuid", "getuid", "fork", "pidfd_open", "fdatasync"]),
    (signal, ["SIGXCPU", "SIGSYS", "SIGKILL", "pthread_sigmask"]),
    (socket, ["SOCK_SEQPACKET", "AF_UNIX", "send_fds", "recv_fds"]),
):
    for name in names:
        if hasattr(module, name):
            delattr(module, name)
sys.path[:0] = sys.argv[1:]
from sdc_experiments import __main__, scenarios
from sdc_experiments.championship import attempt, race, rounds
from sdc_experiments.closed_loop import drive
from sdc_experiments.sweep import command, results

assert drive("slalom", longest_s=3.0)["route_completion_percent"] > 1.0
"""
# Write the traces of drives, and the version of NumPy.
TRACES = """
import sys

file, *folders = sys.argv[1:]
sys.path[:0] = folders
import numpy
from sdc_experiments.closed_loop import drive_result

drives = {
    "slalom": {"scenario": "slalom"},
    "lights": {"scenario": "traffic_lights"},
    "noise": {"scenario": "recorded_noisy", "longest_s": 20.0},
    "town": {"map": "town", "seed": 3, "longest_s": 60.0},
}
traces = {name: drive_result(**arguments).rows for name, arguments in drives.items()}
numpy.savez(file, version=numpy.__version__, **traces)
"""
# Import each module of the wheel, and print those that need what is not installed.
IMPORTS = """
import importlib, pkgutil, sys

for name in sys.argv[1:]:
    for module in pkgutil.walk_packages(importlib.import_module(name).__path__, name + "."):
        if not module.name.endswith("__main__"):
            try:
                importlib.import_module(module.name)
            except (ImportError, ValueError) as error:
                print(f"{module.name}: {error}")
"""


def run(python, code, *arguments):
    """Run Python without this environment, and return its output."""
    done = subprocess.run(
        [python, "-I", "-c", code, *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
        env={},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow(3)
def test_drive_needs_no_ros_and_nothing_that_other_systems_lack():
    run(sys.executable, HIDE, *SOURCES)


@needs_wheel
def test_wheel_is_small_and_has_no_module_that_needs_ros():
    (wheel,) = (VENV / "wheels").glob("*.whl")
    assert wheel.stat().st_size <= MAX_WHEEL
    names = [path.name for path in VENV.glob("lib/*/site-packages/sdc_*") if path.is_dir()]
    packages = sorted(name for name in names if "-" not in name)
    assert len(packages) == 9
    lacking = run(VENV / "bin/python", IMPORTS, *packages).splitlines()
    optional = ("osqp", "casadi", "torch")
    wrong = [line for line in lacking if not any(name in line for name in optional)]
    assert not wrong, "\n".join(wrong)


@needs_wheel
@pytest.mark.slow(15)
def test_wheel_drives_as_the_sources_do(tmp_path):
    ours, wheels = (tmp_path / f"{name}.npz" for name in ("sources", "wheel"))
    run(sys.executable, TRACES, ours, *SOURCES)
    run(VENV / "bin/python", TRACES, wheels)
    expected, found = np.load(ours), np.load(wheels)
    is_same = expected["version"] == found["version"]
    for name, tolerance in TOLERANCES.items():
        tolerance = 0.0 if is_same else tolerance
        np.testing.assert_allclose(
            found[name], expected[name], rtol=0.0, atol=tolerance, err_msg=name
        )


@needs_wheel
@pytest.mark.slow(10)
def test_command_drives_and_writes_pages(tmp_path):
    for words, line in (
        (["drive", "scenario=slalom"], "all limits are met"),
        (["map", "check", "town"], "size: x from"),
        (["gym"], "sdc_experiments.learning:SdcTown-v0"),
        (["scenarios", "--list"], "Accident: "),
    ):
        done = subprocess.run(
            [VENV / "bin/sdc", *words],
            cwd=tmp_path,
            env={},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0 and line in done.stdout, done.stdout + done.stderr
    assert (tmp_path / "report" / "report.html").stat().st_size > 100_000
