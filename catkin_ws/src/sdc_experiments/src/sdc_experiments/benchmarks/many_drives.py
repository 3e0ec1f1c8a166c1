"""Benchmarks of many drives: the Gymnasium environments, and sweeps."""

from __future__ import annotations

import argparse
import importlib.util
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from sdc_common.configuration import package_folder
from sdc_experiments.sweep.cell_drive import code_version, drive_cell
from sdc_experiments.sweep.dask_engine import DaskEngine
from sdc_experiments.sweep.settings import IN_PROCESS
from sdc_experiments.sweep.study import Cell, load_study

_CARS, _WORLDS, _TICKS = 16384, 4096, 400
_DRIVES_PER_WORKER = 60
_STUDY = """about: drives for a benchmark
scenarios: [{scenario}]
settings: {{sim_options/odometry_noise/position_m: 0.02}}
factors:
  simple_controller/stanley_compensated/k: [1.5, 2.0, 2.5, 3.0]
seeds: 30
"""


def learning(_options: argparse.Namespace) -> Iterator[dict[str, float]]:
    """Yield the steps per second of the environments."""
    import gymnasium

    import sdc_experiments.learning  # noqa: F401  registers the environments

    def many(count: int, **arguments: Any) -> Any:
        cars = gymnasium.make_vec(num_envs=count, **arguments)
        cars.reset(seed=0)
        return cars

    town = gymnasium.make("SdcTown-v0", disable_env_checker=True)
    pictures = gymnasium.make("SdcTown-v0", disable_env_checker=True, observation="camera")
    steers = [np.array([0.36, steer], np.float32) for steer in (-0.02, 0.0, 0.02)]
    single = {
        "SdcTown-v0, one car": (town, 10 * _TICKS, steers),
        "the same with pictures": (pictures, _TICKS, steers),
    }
    if importlib.util.find_spec("highway_env"):
        importlib.import_module("highway_env")
        for name in ("highway-fast-v0", "racetrack-v0"):
            rival = gymnasium.make(name)
            drawn = [rival.action_space.sample() for _ in range(_TICKS // 4)]
            single[f"highway-env's {name}"] = rival, len(drawn), drawn
    vectors = {
        f"SdcRandomRoutes-v0, {_CARS:,} cars": (many(_CARS, id="SdcRandomRoutes-v0"), 20, _CARS),
        "SdcTraffic-v0, one thread": (many(_WORLDS, id="SdcTraffic-v0", threads=1), 40, _WORLDS),
        "pictures from two processes": (
            many(2, id="SdcTown-v0", vectorization_mode="async", observation="camera"),
            _TICKS,
            2,
        ),
    }
    warm = False
    while True:
        rates = {name: _single_rate(*row) for name, row in single.items()}
        for name, (cars, steps, count) in vectors.items():
            begin_s = time.perf_counter()
            for _ in range(steps):
                cars.step(np.tile(np.float32([0.36, 0.0]), (count, 1)))
            rates[name] = steps * count / (time.perf_counter() - begin_s)
        # The first round compiles the physics, and draws the ground along the way.
        if warm:
            yield rates
        warm = True


def _single_rate(car: Any, steps: int, actions: list) -> float:
    car.reset(seed=0)
    begin_s = time.perf_counter()
    for tick in range(steps):
        *_, ended, truncated, _ = car.step(actions[tick % len(actions)])
        if ended or truncated:
            car.reset()
    return steps / (time.perf_counter() - begin_s)


def sweep(_options: argparse.Namespace) -> Iterator[dict[str, float]]:
    """Yield the drives of 300 m per second of a sweep with one worker and with two."""
    package = Path(package_folder("sdc_experiments"))
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "benchmark.yaml"
        text = _STUDY.format(scenario=package / "studies" / "bends.yaml")
        path.write_text(text, encoding="utf-8")
        cells = load_study(str(path)).cells()
    with DaskEngine("", 1) as single, DaskEngine("", 2) as pair:
        _drives_per_second(single, cells[:2])
        _drives_per_second(pair, cells[:8])
        while True:
            yield {
                "one worker": _drives_per_second(single, cells[:_DRIVES_PER_WORKER]),
                "two workers": _drives_per_second(pair, cells),
            }


def _drives_per_second(engine: DaskEngine, cells: list[Cell]) -> float:
    version = code_version()
    tasks = ((cell.key, (tuple(cell), IN_PROCESS, 0.0, version)) for cell in cells)
    start_s = time.monotonic()
    errors = [outcome.error for outcome in engine.outcomes(drive_cell, tasks) if outcome.error]
    assert not errors, errors[0]
    return len(cells) / (time.monotonic() - start_s)
