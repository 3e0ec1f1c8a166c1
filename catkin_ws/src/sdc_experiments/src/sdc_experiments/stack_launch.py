"""Launch the whole stack in processes of its own, from this workspace or from another one."""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
import time
from pathlib import Path
from typing import Any, Callable, Iterator, Mapping, NamedTuple, Sequence

from sdc_common.testing.processes import Program, isolated_ros_environment

# What a setup.bash sets. The setup of another workspace must not find that of this one.
_WORKSPACE_VARIABLES = (
    "CMAKE_PREFIX_PATH",
    "LD_LIBRARY_PATH",
    "PKG_CONFIG_PATH",
    "PYTHONPATH",
    "ROSLISP_PACKAGE_DIRECTORIES",
    "ROS_PACKAGE_PATH",
)
_SAMPLE_PERIOD_S = 0.25
_SHOWN_CHARACTERS = 3000


class StackDrive(NamedTuple):
    """A completed drive.

    Attributes:
        report: content of report.json
        samples: (share of the drive's wall time, result of `sample`) in the order of time
    """

    report: dict[str, Any]
    samples: list[tuple[float, Any]]

    @property
    def tick_ms(self) -> float:
        """Return the wall time per tick [ms]."""
        return 1e3 * self.report["wall_duration_s"] / self.report["ticks"]


def launch_command(*arguments: str, setup: str | None = None) -> list[str]:
    """Return the command that launches the stack without windows.

    Args:
        arguments: arguments of all.launch
        setup: setup.bash of the workspace to launch from, None for this workspace
    """
    command = ["roslaunch", "sdc_package", "all.launch", "headless:=true", *arguments]
    return command if setup is None else ["bash", "-c", '. "$0" && exec "$@"', setup, *command]


def launch_environment(variables: Mapping[str, str], setup: str | None) -> dict[str, str]:
    """Return the environment variables for `launch_command`, based on `variables`."""
    removed = () if setup is None else _WORKSPACE_VARIABLES
    return {name: value for name, value in variables.items() if name not in removed}


@contextlib.contextmanager
def running(command: list[str], environment: Mapping[str, str], folder: Path) -> Iterator[Program]:
    """Run a program during a block and interrupt it at the end."""
    program = Program(command, environment, folder, folder / f"log_{time.monotonic_ns()}")
    try:
        yield program
    finally:
        if program.process.poll() is None:
            program.interrupt()


def drive_in_lockstep(
    camera: bool,
    route: str | None = None,
    setup: str | None = None,
    sample: Callable[[str], Any] | None = None,
) -> StackDrive:
    """Drive a route in lockstep, as `drive_stack`.

    Args:
        camera: whether to render and process pictures
        route: CSV file of waypoints, None for the packaged one
        setup: as in drive_stack
        sample: as in drive_stack
    """
    arguments = ["sync:=true", f"camera:={str(camera).lower()}"]
    if route is not None:
        arguments.append(f"waypoints_path:={route}")
    return drive_stack(arguments, setup, sample)


def drive_stack(
    given: Sequence[str],
    setup: str | None = None,
    sample: Callable[[str], Any] | None = None,
) -> StackDrive:
    """Drive under a ROS master of its own.

    Args:
        given: arguments of all.launch
        setup: setup.bash of the workspace to launch from, None for this workspace
        sample: called every 0.25 s with the ROS_MASTER_URI; each call slows the drive a little

    Raises:
        RuntimeError: the drive wrote no report; the message contains the end of its output
    """
    samples = []
    with tempfile.TemporaryDirectory() as name, isolated_ros_environment(name) as variables:
        folder = Path(name)
        report = folder / "report.json"
        arguments = [*given, f"report:={report}"]
        environment = launch_environment(variables, setup)
        with running(launch_command(*arguments, setup=setup), environment, folder) as launch:
            while launch.process.poll() is None:
                if sample is None:
                    launch.wait_for_end()
                    break
                samples.append((time.time(), sample(variables["ROS_MASTER_URI"])))
                time.sleep(_SAMPLE_PERIOD_S)
        if not report.exists():
            raise RuntimeError(f"the drive wrote no report:\n{launch.output[-_SHOWN_CHARACTERS:]}")
        result = json.loads(report.read_text(encoding="utf-8"))
        end_s = os.stat(report).st_mtime
    wall_s = result["wall_duration_s"]
    return StackDrive(result, [(1.0 - (end_s - at) / wall_s, value) for at, value in samples])
