"""Drive roads from waypoints as people have them: coarse, rounded and noisy.

python3 -m sdc_experiments.recorded_roads [COURSE ...]
"""

from __future__ import annotations

import sys
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from sdc_experiments.closed_loop import drive_result
from sdc_experiments.configuration import packaged_config
from sdc_package.steering.loader import METHODS
from sdc_sim.road.route_generator import generate_route

_FINE_M = 0.05
# A method that is too far from the exact road may be so much farther from the recorded one.
_NOISE_ADDS_M = 0.1
SPACINGS_M = (0.4, 1.0, 2.0, 5.0)
SPEEDS_MPS = (10.0, 15.0, 25.0)


class Recording(NamedTuple):
    """How waypoints were taken from a road."""

    spacing_m: float  # distance between them [m]
    rounding_m: float = 0.0  # their coordinates are multiples of it, 0 for exact ones [m]
    noise_m: float = 0.0  # standard deviation of each coordinate [m]
    worst_m: float = 0.15  # distance from the road that a drive may reach [m]

    def waypoints(self, road_m: np.ndarray) -> np.ndarray:
        """Return waypoints (N, 2) of a road (M, 2), whose points are 0.05 m apart [m]."""
        points = road_m[:: round(self.spacing_m / _FINE_M)]
        points = points + np.random.default_rng(7).normal(0.0, self.noise_m, points.shape)
        if self.rounding_m:
            points = self.rounding_m * np.round(points / self.rounding_m)
        return points


RECORDINGS = (
    *[Recording(spacing_m, rounding_m=0.01) for spacing_m in SPACINGS_M],
    *[Recording(spacing_m, rounding_m=0.1) for spacing_m in SPACINGS_M],
    *[Recording(spacing_m, noise_m=0.05, worst_m=0.25) for spacing_m in SPACINGS_M],
)


def road(course: str) -> np.ndarray:
    """Return the points (M, 2) of a course, 0.05 m apart [m]."""
    start = {"x_m": 0.0, "y_m": 0.0, "heading_deg": 17.0}
    spec = {"elements": packaged_config("recorded_roads")[course], "start": start}
    spec["spacing_m"] = _FINE_M
    return generate_route(spec)[:, :2]


def measure(road_m: np.ndarray, recording: Recording, method: str, speed_mps: float) -> dict:
    """Drive along the waypoints of a recording.

    Returns:
        the report of the drive, and as `from_road_m` the greatest distance from the road [m]
    """
    drive = drive_result(
        route=recording.waypoints(road_m),
        steering=method,
        planner_options={"planned_speed_mps": speed_mps},
    )
    places = drive.rows[:, 1:3]
    distance_m, nearest = cKDTree(road_m).query(places)
    # Noise along the road moves its ends, which no drive can know.
    inside = (nearest > 0) & (nearest < len(road_m) - 1)
    return {**drive.metrics, "from_road_m": float(distance_m[inside].max())}


def failures(exact: dict[str, Any], recorded: dict[str, Any], recording: Recording) -> list[str]:
    """Return what is worse than in a drive along the exact road by more than allowed."""
    found = []
    if recorded["status"] != "completed":
        found.append(recorded["status"])
    # The textbook law of Stanley deviates by 0.21 m on the exact road at 25 m/s.
    if recorded["from_road_m"] > max(recording.worst_m, exact["from_road_m"] + _NOISE_ADDS_M):
        found.append("distance")
    for key, factor in (("lateral_acceleration_max_mps2", 1.3), ("duration_s", 1.05)):
        if recorded[key] > factor * exact[key]:
            found.append(key)
    if recorded["time_ratio"] < 1.0:
        found.append("time_ratio")
    if exact["comfortable"] and not recorded["comfortable"]:
        found.append("comfort")
    return found


def main() -> None:
    """Drive all courses with every steering method and print a table."""
    for course in sys.argv[1:] or packaged_config("recorded_roads"):
        road_m = road(course)
        for speed_mps in SPEEDS_MPS:
            for method in METHODS:
                exact = measure(road_m, Recording(1.0), method, speed_mps)
                print(f"{course}, {speed_mps:g} m/s, {method}: {_row(exact, exact)}", flush=True)
                for recording in RECORDINGS:
                    recorded = measure(road_m, recording, method, speed_mps)
                    found = ", ".join(failures(exact, recorded, recording))
                    print(f"  {_name(recording)}: {_row(recorded, exact)} {found}", flush=True)


def _name(recording: Recording) -> str:
    kind = f"rounded to {recording.rounding_m:g} m"
    if recording.noise_m:
        kind = f"noise of {recording.noise_m:g} m"
    return f"{kind}, every {recording.spacing_m:g} m"


def _row(drive: dict[str, Any], exact: dict[str, Any]) -> str:
    lateral = drive["lateral_acceleration_max_mps2"]
    return (
        f"{drive['from_road_m']:.3f} m, {lateral:.2f} m/s2 "
        f"(x{lateral / exact['lateral_acceleration_max_mps2']:.2f}), "
        f"jerk {drive['jerk_max_mps3']:.1f}, {drive['duration_s']:.1f} s "
        f"(x{drive['duration_s'] / exact['duration_s']:.3f}), ratio {drive['time_ratio']:.3f}"
    )


if __name__ == "__main__":
    main()
