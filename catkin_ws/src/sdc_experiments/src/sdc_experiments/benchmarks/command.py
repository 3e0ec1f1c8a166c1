"""rosrun sdc_experiments benchmark.py NAME ...: measure rounds of a benchmark and print a table."""

from __future__ import annotations

import argparse
import functools
import importlib
import itertools
import multiprocessing
import os
import sys
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np

from sdc_common.configuration import package_folder


class Benchmark(NamedTuple):
    """A row of the table of benchmarks."""

    measures: str  # what it measures
    function: str  # module and name of the generator of rounds
    unit: str  # unit of its values
    arguments: dict[str, Any] = {}  # arguments of the generator


_CAMERA = ({"camera": False}, {"camera": True})
BENCHMARKS = {
    "tick": Benchmark("a tick in lockstep over a bare loop", "stack.tick", "ms", _CAMERA[0]),
    "tick_camera": Benchmark("the same with pictures", "stack.tick", "ms", _CAMERA[1]),
    "cpu": Benchmark("CPU time of each process in a tick", "stack.cpu", "ms", _CAMERA[0]),
    "cpu_camera": Benchmark("the same with pictures", "stack.cpu", "ms", _CAMERA[1]),
    "parts": Benchmark("each part of a tick alone", "parts.parts", "ms"),
    "camera": Benchmark("pictures of the camera", "parts.camera", "pictures/s"),
    "lidar": Benchmark("a scan of each lidar", "parts.lidar", "ms"),
    "learning": Benchmark("the Gymnasium environments", "many_drives.learning", "steps/s"),
    "sweep": Benchmark("drives of a sweep", "many_drives.sweep", "drives/s"),
}


def parse(arguments: list[str]) -> argparse.Namespace:
    """Parse the command line."""
    routes = Path(package_folder("sdc_package")) / "test" / "routes"
    parser = argparse.ArgumentParser(prog="benchmark.py", description="Measure what things cost.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="none: list all benchmarks")
    parser.add_argument("--rounds", type=int, default=5, help="rounds of each benchmark")
    parser.add_argument("--route", default=str(routes / "fast_bends.csv"), help="waypoints of tick")
    parser.add_argument("--setup", help="of tick: setup.bash of another workspace to compare with")
    options = parser.parse_args(arguments)
    unknown = [name for name in options.names if name not in BENCHMARKS]
    if unknown:
        parser.error(f"no benchmark '{unknown[0]}'; use some of {', '.join(BENCHMARKS)}")
    if options.rounds < 1:
        parser.error(f"--rounds must be positive, got {options.rounds}")
    for name in ("route", "setup"):
        path = getattr(options, name)
        if path is not None and not os.path.isfile(path):
            parser.error(f"--{name}: there is no file {path}")
    return options


def measure(name: str, options: argparse.Namespace) -> None:
    """Measure the rounds of one benchmark and print its table."""
    cv2.setNumThreads(1)
    benchmark = BENCHMARKS[name]
    module, function = benchmark.function.split(".")
    generator = getattr(importlib.import_module(f"sdc_experiments.benchmarks.{module}"), function)
    rounds = generator(options, **benchmark.arguments)
    try:
        found = list(itertools.islice(rounds, options.rounds))
    finally:
        rounds.close()
    print(table(name, found), flush=True)


def table(name: str, rounds: list[dict[str, float]]) -> str:
    """Return the table of some rounds.

    The ratio is the median of the ratios to the first line, each within one round.
    """
    benchmark, load = BENCHMARKS[name], os.getloadavg()[0]
    head = f"{name}: {benchmark.measures} [{benchmark.unit}]"
    lines = [f"{head}, {len(rounds)} rounds, load {load:.1f}"]
    lines.append(f"{'':32}{'median':>12}{'least':>12}{'greatest':>12}{'ratio':>9}")
    first = next(iter(rounds[0]))
    for label in rounds[0]:
        values = np.array([times.get(label, np.nan) for times in rounds])
        ratio = np.median(values / [times[first] for times in rounds])
        numbers = "".join(f"{number:12,.5g}" for number in np.percentile(values, [50, 0, 100]))
        lines.append(f"{label:32}{numbers}{ratio:9.2f}")
    return "\n".join(lines)


def main() -> None:
    """Run the command. Each benchmark has a process of its own, as it has a ROS node."""
    options = parse(sys.argv[1:])
    for name, benchmark in BENCHMARKS.items() if not options.names else ():
        print(f"{name:16}{benchmark.measures} [{benchmark.unit}]")
    start = functools.partial(multiprocessing.get_context("spawn").Process, target=measure)
    for name in options.names:
        process = start(args=(name, options))
        process.start()
        process.join()
        if process.exitcode:
            sys.exit(1)
