"""Launch the whole stack in processes of its own, from this workspace or from another one."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any, Iterator, Mapping, NamedTuple, Sequence

from sdc_common.processes import isolated_ros_environment
from sdc_sim.catkin_workspace import PATH_VARIABLES

REPORT = "report.json"
_SHOWN_CHARACTERS = 3000
_DRIVE_TIMEOUT_S = 200.0


class Program(NamedTuple):
    """A running program."""

    process: subprocess.Popen  # the process
    environment: Mapping[str, str]  # all its environment variables
    log: Path  # the file that receives its output

    @property
    def output(self) -> str:
        """Return all output so far."""
        return self.log.read_text(errors="replace")


@contextlib.contextmanager
def running(
    command: Sequence[str], environment: Mapping[str, str], folder: Path
) -> Iterator[Program]:
    """Run a program during a block and interrupt it at the end."""
    log = folder / f"log_{time.monotonic_ns()}"
    with open(log, "wb") as output:
        process = subprocess.Popen(
            command,
            cwd=folder,
            env={**environment, "PWD": str(folder), "PYTHONUNBUFFERED": "1"},
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    try:
        yield Program(process, environment, log)
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(_DRIVE_TIMEOUT_S)


@contextlib.contextmanager
def launched(given: Sequence[str], setup: str | None = None) -> Iterator[Program]:
    """Run all.launch without windows, under a ROS master of its own, during a block.

    It is that of this workspace, or of the one with this setup.bash.
    """
    with tempfile.TemporaryDirectory() as name, isolated_ros_environment(name) as environment:
        command = ["roslaunch", "sdc_package", "all.launch", "headless:=true"]
        command += [f"report:={Path(name) / REPORT}", *given]
        if setup is not None:
            command = ["bash", "-c", '. "$0" && exec "$@"', os.path.abspath(setup), *command]
            # The setup of another workspace must not find that of this one.
            environment = {
                key: environment[key] for key in environment if key not in PATH_VARIABLES
            }
        with running(command, environment, Path(name)) as launch:
            yield launch


def report_of(launch: Program) -> dict[str, Any]:
    """Return the content of report.json of a drive, after its end.

    Raises:
        RuntimeError: the drive wrote no report; the message contains the end of its output
    """
    launch.process.wait(_DRIVE_TIMEOUT_S)
    try:
        return json.loads(launch.log.with_name(REPORT).read_text(encoding="utf-8"))
    except OSError:
        output = launch.output[-_SHOWN_CHARACTERS:]
        raise RuntimeError(f"the drive wrote no report:\n{output}") from None
