"""Drives on fast bends, in one process.

python3 -m sdc_mpc.drives [SEED ...] [NAME ...] drives with what you have written; NAME is one of
VARIANTS, the same driver with something else that it wants or knows.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from typing import Any, Callable

import numpy as np

from sdc_mpc.driver import DELAY_TICKS, TICK_S, PredictiveDriver, Tuning
from sdc_mpc.limits import limits
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.physics.vehicle_parameters import load_vehicle
from sdc_sim.road.random_routes import long_route
from sdc_sim.simulation.loop import drive
from sdc_sim.simulation.simulation import Simulation
from sdc_sim.simulation.snapshot import Snapshot
from sdc_sim.yaml_document import config_path

VARIANTS = {
    "default": Tuning(),
    "no-delay": Tuning(delay_ticks=0),
    "short": Tuning(ticks=5),
    "nervous": Tuning(change_weights=(0.01, 2.0)),
    "lazy": Tuning(change_weights=(4000.0, 2.0)),
    "only-speed": Tuning(weights=(0.001, 0.001, 0.3)),
}
_LENGTH_M = 600.0  # length of the road
_LEAST_RADIUS_M = 25.0  # radius of its tightest bend
_FASTEST_MPS = 20.0
_LATERAL_MPS2 = 3.0  # lateral acceleration of the planned speed in bends
_BRAKING_MPS2 = 2.5
_FINISH_M = 30.0  # distance of the finish to the end of the road
_LOST_M = 5.0  # a car farther from the middle of the road has lost it
_LONGEST_S = 120.0


@dataclass
class DrivenBends:
    """A drive on bends."""

    arrived: bool = False  # whether the car arrived, less than 5 m from the path all the time
    rms_m: float = np.inf  # root mean square of the cross-track error
    worst_m: float = np.inf  # greatest cross-track error
    mean_mps: float = 0.0  # mean speed
    # (T, 6) time [s], place [m], cross-track error [m], speed [m/s], wheel angle [rad],
    # acceleration [m/s^2]
    rows: np.ndarray = field(default_factory=lambda: np.empty((0, 6)), repr=False)


def planned_speeds(points_m: np.ndarray) -> np.ndarray:
    """Return the speed at each point: slow enough in its bend, and braking gently before it."""
    headings = np.unwrap(np.arctan2(*np.diff(points_m, axis=0).T[::-1]))
    bends = np.abs(np.convolve(np.diff(headings), np.ones(3) / 3.0, "same"))
    speeds = np.full(len(points_m), _FASTEST_MPS)
    speeds[1:-1] = np.minimum(_FASTEST_MPS, np.sqrt(_LATERAL_MPS2 / np.maximum(bends, 1e-6)))
    for i in range(len(speeds) - 2, -1, -1):
        speeds[i] = min(speeds[i], np.sqrt(speeds[i + 1] ** 2 + 2.0 * _BRAKING_MPS2))
    return speeds


class _BendReferee:
    """Measures the drive, and ends it."""

    def __init__(self, driver: PredictiveDriver):
        self._driver = driver
        self._rows: list = []
        self.result = DrivenBends()

    def add(self, snapshot: Snapshot, command: Any, car: Any) -> bool:
        """Add a tick; return whether the drive is over."""
        driver, time_s = self._driver, TICK_S * len(self._rows)
        speed = snapshot.state.speed_mps
        self._rows.append((time_s, driver.place_m, driver.cross_track_m, speed, *driver.command))
        arrived = driver.place_m > driver.line.s[-1] - _FINISH_M
        lost = abs(driver.cross_track_m) > _LOST_M or time_s > _LONGEST_S
        if arrived or lost:
            rows = np.array(self._rows)
            errors, result = rows[:, 2], self.result
            result.rows, result.arrived = rows, not lost
            result.rms_m, result.worst_m = np.sqrt(np.mean(errors**2)), np.abs(errors).max()
            result.mean_mps = driver.place_m / time_s
        return arrived or lost


def drive_bends(seed: int, tuning: Tuning | None = None, limited: Callable = limits) -> DrivenBends:
    """Drive the random bends of a seed, with commands that act 0.1 s late.

    `limited` gives the limits of the inputs.
    """
    points = long_route(seed, _LENGTH_M, _LEAST_RADIUS_M)
    driver = PredictiveDriver(points, planned_speeds(points), tuning or Tuning(), limited)
    vehicle = Vehicle(load_vehicle(config_path("vehicles/tesla_model3.yaml")))
    (x, y), yaw = points[0].tolist(), driver.line.headings[0]
    world = Simulation(
        vehicle, TICK_S, 0.5, start=(x, y, yaw), command_latency_s=DELAY_TICKS * TICK_S
    )
    referee = _BendReferee(driver)
    drive(world, driver, referee)  # type: ignore[arg-type]
    return referee.result


def main() -> None:
    """Print a line for each drive."""
    names = [word for word in sys.argv[1:] if word in VARIANTS] or ["default"]
    seeds = [int(word) for word in sys.argv[1:] if word.isdecimal()] or [1, 2, 3]
    for name in names:
        for seed in seeds:
            result = drive_bends(seed, VARIANTS[name])
            errors = f"RMS {100 * result.rms_m:.1f} cm, worst {100 * result.worst_m:.1f} cm"
            rate = np.sqrt(np.mean(np.diff(result.rows[:, 4]) ** 2)) / TICK_S
            end = "arrived" if result.arrived else "lost the road"
            line = f"{name} {seed}: {end}, {errors}, {result.mean_mps:.1f} m/s"
            print(f"{line}, steering {rate:.2f} rad/s", flush=True)


if __name__ == "__main__":
    main()
