"""Drives of the whole stack, and CPU time, memory and open files of its processes."""

from __future__ import annotations

import contextlib
import functools
import os
from collections import defaultdict
from typing import Any

import psutil

from sdc_common.processes import processes_with
from sdc_sim.runner import isolated_drive
from sdc_sim.scenario.acceptance_limits import read_report

_NODE = "__name:="
_MEGABYTE = 1024.0 * 1024.0
# Takes a ROS_MASTER_URI, and returns the processes that were started with it.
stack_processes = functools.partial(processes_with, "ROS_MASTER_URI")


def measured_drive(camera: str, **options: Any) -> dict[str, Any]:
    """Drive in lockstep with the options of isolated_drive; return the content of report.json.

    Raises:
        RuntimeError: the drive wrote no report; the message has the end of its output
    """
    arguments = {"camera": camera, "referee_options": "{}", **options.pop("given", {})}
    with isolated_drive("", arguments, **options) as (drive, lines):
        try:
            return read_report(drive.report_path)[0]
        except OSError:
            raise RuntimeError("\n".join(lines)) from None


def process_name(process: psutil.Process) -> str:
    """Return the name of a process: that of its node, or of its program.

    Raises:
        psutil.Error: the process has ended
    """
    words = process.cmdline()
    node = next((word[len(_NODE) :] for word in words if word.startswith(_NODE)), None)
    if node is not None:
        return node
    programs = [os.path.basename(word) for word in words[:3]]
    return next((name for name in programs if name.startswith(("ros", "sdc_"))), process.name())


def cpu_ms(master_uri: str) -> dict[str, float]:
    """Return the CPU time that the processes of a ROS master have used, by process name [ms]."""
    used: dict[str, float] = defaultdict(float)
    for process in stack_processes(master_uri):
        with contextlib.suppress(psutil.Error):
            times = process.cpu_times()
            used[process_name(process)] += 1e3 * (times.user + times.system)
    return dict(used)


def private_memory_mb(process: psutil.Process) -> float:
    """Return the resident memory of a process that is not shared [MB].

    Raises:
        psutil.Error: the process has ended
    """
    memory = process.memory_info()
    return (memory.rss - memory.shared) / _MEGABYTE
