"""Benchmarks of the whole stack in separate processes."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator

from sdc_experiments.benchmarks.bare_loop import bare_loop
from sdc_experiments.process_metrics import cpu_ms
from sdc_experiments.stack_launch import REPORT, launched, report_of

_SAMPLE_PERIOD_S = 0.1
# Start and end of a drive are left out of the CPU time.
_STEADY_FROM, _STEADY_UNTIL = 0.3, 0.8
_LEAST_CPU_MS = 0.05


def tick(options: argparse.Namespace, camera: bool) -> Iterator[dict[str, float]]:
    """Yield the times of a tick of the bare loop and of drives in lockstep [ms]."""
    given = ["sync:=true", f"camera:={str(camera).lower()}", f"waypoints_path:={options.route}"]
    stacks = {"this workspace": None}
    if options.setup:
        stacks[options.setup] = options.setup
    with bare_loop() as world:
        while True:
            round_ms = {"bare loop": world.tick_ms(camera)}
            for name, setup in stacks.items():
                with launched(given, setup) as launch:
                    report = report_of(launch)
                round_ms[name] = 1e3 * report["wall_duration_s"] / report["ticks"]
            yield round_ms


def cpu(_options: argparse.Namespace, camera: bool) -> Iterator[dict[str, float]]:
    """Yield the CPU time of each process in a tick of the packaged route in lockstep [ms]."""
    while True:
        with launched(["sync:=true", f"camera:={str(camera).lower()}"]) as launch:
            uri, samples = launch.environment["ROS_MASTER_URI"], []
            while launch.process.poll() is None and not launch.log.with_name(REPORT).exists():
                samples.append((time.monotonic(), cpu_ms(uri)))
                time.sleep(_SAMPLE_PERIOD_S)
            end_s = time.monotonic()
            report = report_of(launch)
        wall_s = report["wall_duration_s"]
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
