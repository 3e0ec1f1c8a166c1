"""Steps per second of the Gymnasium environments, next to highway-env on the same machine.

python3 -m sdc_experiments.benchmark_learning [ROUNDS]

highway-env runs in its own virtual environment, which docker/prepare highway installs.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Callable, Tuple

import cv2
import gymnasium
import numpy as np
import rospkg

import sdc_experiments.learning  # noqa: F401  registers the environments

# Steps per second, and per second of CPU time.
Rates = Tuple[float, float]

_CARS = 16384
_TICKS = 400
_WARM_UP_TICKS = 40
_HIGHWAY = """
import time, gymnasium, highway_env
gymnasium.register_envs(highway_env)
environment = gymnasium.make("{name}", disable_env_checker=True)
environment.reset(seed=0)
steps, begin, begin_cpu = 0, time.perf_counter(), time.process_time()
while time.perf_counter() - begin < {seconds}:
    _, _, ended, truncated, _ = environment.step(environment.action_space.sample())
    steps += 1
    if ended or truncated:
        environment.reset()
print(steps / (time.perf_counter() - begin), steps / (time.process_time() - begin_cpu))
"""
_HIGHWAY_S = 4.0


def _single(**arguments: Any) -> Callable[[int], int]:
    """Return a function that drives so many steps and returns their number."""
    environment = gymnasium.make("SdcTown-v0", disable_env_checker=True, **arguments)
    environment.reset(seed=0)

    def drive(steps: int) -> int:
        environment.reset()
        for tick in range(steps):
            action = np.array([0.36, 0.02 * (tick % 3 - 1)], np.float32)
            *_, ended, truncated, _ = environment.step(action)
            if ended or truncated:
                environment.reset()
        return steps

    return drive


def _pictures() -> Callable[[int], int]:
    """Return a function that drives so many steps in each of two processes."""
    count = 2
    cars = gymnasium.make_vec("SdcTown-v0", count, vectorization_mode="async", observation="camera")
    cars.reset(seed=0)

    def drive(steps: int) -> int:
        cars.reset()
        for tick in range(steps):
            action = np.array([0.36, 0.02 * (tick % 3 - 1)], np.float32)
            cars.step(np.tile(action, (count, 1)))
        return steps * count

    return drive


def _many() -> Callable[[int], int]:
    cars = gymnasium.make_vec("SdcRandomRoutes-v0", _CARS)
    cars.reset(seed=0)
    actions = np.full((_CARS, 2), (0.4, 0.0), np.float32)

    def drive(steps: int) -> int:
        for _ in range(steps):
            cars.step(actions)
        return steps * _CARS

    return drive


def _rate(drive: Callable[[int], int], steps: int) -> Rates:
    begin, begin_cpu = time.perf_counter(), time.process_time()
    count = drive(steps)
    return count / (time.perf_counter() - begin), count / (time.process_time() - begin_cpu)


def _highway_rate(name: str) -> Rates:
    """Return the rates of an environment of highway-env, NaN if it is not installed."""
    project = Path(rospkg.RosPack().get_path("sdc_experiments")).parents[2]
    python = project / ".highway" / "bin" / "python"
    if not python.exists():
        return math.nan, math.nan
    variables = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    script = _HIGHWAY.format(name=name, seconds=_HIGHWAY_S)
    done = subprocess.run(
        [python, "-W", "ignore", "-c", script], env=variables, stdout=subprocess.PIPE, check=True
    )
    wall, cpu = map(float, done.stdout.split()[-2:])
    return wall, cpu


def main() -> None:
    """Measure all rates in turns and print the median and the greatest of each."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    # The parts of a picture are small: a second thread costs more than it saves.
    cv2.setNumThreads(1)
    single, many, camera = _single(), _many(), _single(observation="camera")
    pictures = _pictures()
    measures: dict[str, Callable[[], Rates]] = {
        "SdcTown-v0, one car": lambda: _rate(single, 10 * _TICKS),
        f"SdcRandomRoutes-v0, {_CARS} cars": lambda: _rate(many, 20),
        "SdcTown-v0, pictures of 640 x 480": lambda: _rate(camera, _TICKS),
        "the same with two processes": lambda: (_rate(pictures, _TICKS)[0], math.nan),
        "highway-env, highway-v0": lambda: _highway_rate("highway-v0"),
        "highway-env, highway-fast-v0": lambda: _highway_rate("highway-fast-v0"),
    }
    # The first steps compile the physics, and draw the ground along the way.
    for drive, ticks in ((single, 1), (many, _WARM_UP_TICKS), (camera, _TICKS), (pictures, _TICKS)):
        drive(ticks)
    rates = np.array([[measure() for measure in measures.values()] for _ in range(rounds)])
    print(f"{rounds} rounds, load {os.getloadavg()[0]:.1f}")
    print(f"{'steps per second':<36}    median  greatest  per second of CPU time (median)")
    medians, greatest = np.median(rates, axis=0), np.max(rates, axis=0)
    for name, (median, cpu), (best, _) in zip(measures, medians, greatest):
        print(f"{name:<36} {median:>9.0f} {best:>9.0f} {cpu:>9.0f}")
    if np.isnan(rates[0][-1]).any():
        print("highway-env is not installed: docker/prepare highway")


if __name__ == "__main__":
    main()
