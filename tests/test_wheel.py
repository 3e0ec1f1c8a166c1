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
# Greatest difference of a drive with another version of NumPy [m, rad, m/s]. The last bit of a sine
# can change the last bit of a command, which is rounded to float32: by up to 6e-8.
TOLERANCE = 1e-6

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
# Print the files of tests whose imports need neither ROS nor what is not in the wheel.
TESTS = """
import importlib, re, sys
from pathlib import Path

for folder in map(Path, sys.argv[1:]):
    sys.path.insert(0, str(folder))
    for path in folder.glob("test_*.py"):
        text = path.read_text(encoding="utf-8")
        try:
            for name in re.findall(r"^(?:from|import) ([\\w.]+)", text, re.MULTILINE):
                importlib.import_module(name)
        except ImportError:
            continue
        print(f"test: {path}")
"""
# They run programs of the workspace.
PROGRAMS = (
    "test_report_without_usable_events_is_refused_in_one_line",
    "test_method_of_a_lab_that_is_not_in_the_workspace_names_the_command_that_adds_it",
)


def output_of(command, folder, environment=None):
    """Run a program without this environment, and return its output."""
    done = subprocess.run(
        [*map(str, command)],
        cwd=folder,
        env=environment or {},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def run(python, code, *arguments):
    """Run Python without this environment, and return its output."""
    return output_of([python, "-I", "-c", code, *arguments], ROOT)


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
    wrong = [line for line in lacking if "torch" not in line]
    assert not wrong, "\n".join(wrong)


@needs_wheel
@pytest.mark.slow(15)
def test_wheel_drives_as_the_sources_do(tmp_path):
    ours, wheels = (tmp_path / f"{name}.npz" for name in ("sources", "wheel"))
    run(sys.executable, TRACES, ours, *SOURCES)
    run(VENV / "bin/python", TRACES, wheels)
    expected, found = np.load(ours), np.load(wheels)
    tolerance = 0.0 if expected["version"] == found["version"] else TOLERANCE
    for name in expected.files:
        if name != "version":
            np.testing.assert_allclose(
                found[name], expected[name], rtol=0.0, atol=tolerance, err_msg=name
            )


@needs_wheel
@pytest.mark.slow(40)
def test_tests_of_the_library_pass_with_the_wheel():
    names = ("sdc_common", "sdc_map", "sdc_sim", "sdc_package")
    folders = [PACKAGES / name / "test" for name in names]
    found = run(VENV / "bin/python", TESTS, *folders).splitlines()
    files = [line[len("test: ") :] for line in found if line.startswith("test: ")]
    assert len(files) > 60  # the others need ROS
    options = ["-o", "addopts=", "-p", "no:cacheprovider"]
    options += ["--import-mode=importlib", "--hypothesis-profile=quick"]
    options += ["-q", "-m", "not slow and not nightly", "-k", f"not {' and not '.join(PROGRAMS)}"]
    output_of([VENV / "bin/python", "-I", "-m", "pytest", *options, *files], ROOT)


@needs_wheel
@pytest.mark.slow(20)
def test_command_drives_and_writes_pages(tmp_path):
    programs = str(VENV / "bin")  # bubblewrap is not there
    for words, line, environment in (
        (["drive", "scenario=slalom", "steering_method=mpc"], "all limits are met", {}),
        (["drive", "map=random", "traffic=10", "seed=3"], "drive: completed", {}),
        (["map", "check", "town"], "size: x from", {}),
        (["gym"], "sdc_experiments.learning:SdcTown-v0", {}),
        (["scenarios", "--list"], "Accident: ", {}),
        (["championship", "new", "my_driver.py"], "sdc championship try my_driver.py", {}),
        (["championship", "try", "my_driver.py", "drives=1"], "1 drives completed", {}),
        (
            ["championship", "try", "my_driver.py", "drives=1"],
            "no sandbox: bwrap is not installed",
            {"PATH": programs},
        ),
    ):
        assert line in output_of([VENV / "bin/sdc", *words], tmp_path, environment)
    assert (tmp_path / "report" / "report.html").stat().st_size > 100_000
