"""Let pytest run the rostests (*.test) with the unit tests, so that one result counts them all."""

import importlib.util
import os
import re
import signal
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# Without a catkin build, the tests that need no message import the libraries from their sources.
if importlib.util.find_spec("sdc_common") is None:
    _SRC = Path(__file__).parent / "catkin_ws" / "src"
    sys.path += map(str, [*_SRC.glob("*/src"), *_SRC.glob("labs/*/src")])

# The examples are the same in every run. No deadline: a busy machine is no failure.
settings.register_profile("workshop", derandomize=True, deadline=None)
# The first examples of these: ./test --quick
settings.register_profile("quick", max_examples=20, derandomize=True, deadline=None)
# New examples in each run, and many: HYPOTHESIS_PROFILE=nightly ./test -k fuzz
settings.register_profile(
    "nightly",
    max_examples=10_000,
    deadline=None,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "workshop"))

# A shell starts a background job with SIGINT ignored, and every program of a test would inherit it.
signal.signal(signal.SIGINT, signal.default_int_handler)

_LIMIT_S = 400
# The time limit of a rostest, times this, is about its duration.
_SHARE_OF_LIMIT = 0.125


# .ci/run adds the nightly tests of the weekday, 1 on Monday.
_DAYS = range(1, 8)


def pytest_configure(config):
    """Register the days, and give each worker a network of its own, where that is permitted.

    A ROS master asks the old address of a killed node to shut down when the node starts again. A
    program of another worker may have got that address.
    """
    for day in _DAYS:
        config.addinivalue_line("markers", f"nightly_{day}: a seventh of the nightly tests")
    if hasattr(config, "workerinput"):
        from sdc_common.processes import isolate_network

        isolate_network()


def pytest_collect_file(file_path, parent):
    if file_path.suffix == ".test":
        return RosTestFile.from_parent(parent, path=file_path)
    return None


def _seconds(item):
    mark = item.get_closest_marker("slow")
    return mark.args[0] if mark else 0.0


@pytest.hookimpl(tryfirst=True)  # before -m selects
def pytest_collection_modifyitems(items):
    """Mark each nightly test with its day, and put the slowest files first.

    Pytest-xdist distributes files in the order of collection.
    """
    for item in items:
        if item.get_closest_marker("nightly"):
            day = _DAYS[zlib.crc32(item.nodeid.encode()) % len(_DAYS)]
            item.add_marker(f"nightly_{day}")
    seconds = {}
    for item in items:
        seconds[item.path] = max(_seconds(item), seconds.get(item.path, 0.0))
    items.sort(key=lambda item: -seconds[item.path])


class RosTestFile(pytest.File):
    def collect(self):
        yield RosTestItem.from_parent(self, name="rostest")


class RosTestItem(pytest.Item):
    """A rostest file: it passes if rostest does and at least one of its tests ran."""

    def __init__(self, **keywords):
        super().__init__(**keywords)
        text = self.path.read_text(encoding="utf-8")
        limits = re.findall(r'time-limit="(\d+)"', text)
        if "<!-- nightly -->" in text:
            self.add_marker(pytest.mark.nightly)
        self.add_marker(pytest.mark.slow(_SHARE_OF_LIMIT * max(map(float, limits), default=60.0)))

    def runtest(self):
        results = os.path.join(
            str(self.config.rootpath), "catkin_ws", "build", "test_results", "pytest"
        )
        command = ["rostest", "--results-base-dir", results, str(self.path)]
        try:
            # Drives that run at the same time must not write files in the same folder.
            with tempfile.TemporaryDirectory() as folder:
                done = subprocess.run(
                    command,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.STDOUT,
                    text=True,
                    timeout=_LIMIT_S,
                    check=False,
                    cwd=folder,
                    env={**os.environ, "PWD": folder},
                )
        except subprocess.TimeoutExpired as error:
            raise RosTestFailure(f"no end after {_LIMIT_S} s\n{_text(error.stdout)}") from error
        if done.returncode != 0 or _count(done.stdout) == 0:
            raise RosTestFailure(f"{' '.join(command)} ended with {done.returncode}\n{done.stdout}")

    def repr_failure(self, excinfo):
        return (
            str(excinfo.value)
            if isinstance(excinfo.value, RosTestFailure)
            else super().repr_failure(excinfo)
        )

    def reportinfo(self):
        return self.path, 0, self.path.name


class RosTestFailure(Exception):
    pass


def _text(output):
    return output.decode(errors="replace") if isinstance(output, bytes) else output or ""


def _count(output):
    for line in output.splitlines():
        if line.strip().startswith("* TESTS:"):
            return int(line.split(":")[1])
    return 0
