"""Benchmarks of the whole stack in separate processes."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Iterator

from sdc_experiments.benchmarks.bare_loop import bare_loop
from sdc_experiments.process_metrics import cpu_ms, measured_drive
from sdc_sim.catkin_workspace import workspace_environment
from sdc_sim.runner import CheckedDrive

_STEADY_FROM = 0.3  # share of a drive after which the CPU time is measured
_STEADY_UNTIL = 0.8  # share of a drive until which the CPU time is measured
_LEAST_CPU_MS = 0.05


def tick(options: argparse.Namespace, camera: bool) -> Iterator[dict[str, float]]:
    """Yield the times of a tick of the bare loop and of drives in lockstep [ms]."""
    arguments = {"waypoints_path": options.route}
    stacks: dict[str, dict[str, str] | None] = {"this workspace": None}
    if options.setup:
        stacks[options.setup] = workspace_environment(os.path.dirname(options.setup))
    with bare_loop() as world:
        while True:
            round_ms = {"bare loop": world.tick_ms(camera)}
            for name, variables in stacks.items():
                report = measured_drive(str(camera).lower(), given=arguments, environment=variables)
                round_ms[name] = 1e3 * report["wall_duration_s"] / report["ticks"]
            yield round_ms


def cpu(_options: argparse.Namespace, camera: bool) -> Iterator[dict[str, float]]:
    """Yield the CPU time of each process in a tick of the packaged route in lockstep [ms]."""
    while True:
        samples: list[tuple[float, dict[str, float]]] = []

        def sample(drive: CheckedDrive, samples: list = samples) -> None:
            if not os.path.exists(drive.report_path):
                used = cpu_ms(drive.environment["ROS_MASTER_URI"])
                samples.append((time.monotonic(), used))

        report = measured_drive(str(camera).lower(), watch=sample)
        wall_s, end_s = report["wall_duration_s"], samples[-1][0]
        steady = [
            (1.0 - (end_s - at_s) / wall_s, used)
            for at_s, used in samples
            if _STEADY_FROM < 1.0 - (end_s - at_s) / wall_s < _STEADY_UNTIL
        ]
        (first_share, first), (last_share, last) = steady[0], steady[-1]
        ticks = (last_share - first_share) * report["ticks"]
        used = {name: (last[name] - first[name]) / ticks for name in first if name in last}
        shown = sorted(used.items(), key=lambda item: -item[1])
        yield {
            "one tick, wall time": 1e3 * wall_s / report["ticks"],
            "all processes": sum(used.values()),
            **{name: value for name, value in shown if value >= _LEAST_CPU_MS},
        }
