#!/usr/bin/env python3
"""Call a module of the car's library with known arguments; print the results as JSON.

The JSON is the last line of the output. The results under "other" are those for arguments that the
seed decides about: no program can have them written into it. Usage: library_probe.py MODULE SEED
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from random import Random
from types import SimpleNamespace

sys.path.append(str(Path(__file__).parent))

from localization_probe import LOCALIZATION_PROBES  # noqa: E402
from perception_probe import PERCEPTION_PROBES  # noqa: E402


def lane_filter(random: Random) -> dict:
    """Return the shape of a mask, and how many pixels it marks in some areas."""
    from road_picture import road

    from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds

    lane_filter = LaneFilter(LaneFilterThresholds(70, 90, 110, 0.52))
    wide = road()
    left = random.randrange(330, 380)
    wide[250:, left : left + random.randrange(20, 120), :3] = (20, 200, 230)
    mask, other = lane_filter.mask(road()), lane_filter.mask(wide)
    if mask.shape != (480, 640):
        areas = ("white_line", "yellow_line", "sky", "asphalt")
        return {"shape": list(mask.shape), **dict.fromkeys(areas, 0), "other": []}
    return {
        "shape": list(mask.shape),
        "white_line": int((mask[300:, 98:112] > 0).sum()),
        "yellow_line": int((mask[300:, 303:307] > 0).sum()),
        "sky": int((mask[:249] > 0).sum()),
        "asphalt": int((mask[300:, 150:280] > 0).sum()),
        "other": [round(int((other > 0).sum()) / 2000)],
    }


def pid(random: Random) -> dict:
    """Return outputs of a controller with some gains."""
    from sdc_package.pid import Pid, PidGains

    def run(gains: tuple, steps: list, **more: float) -> list:
        controller = Pid(PidGains(*gains), -100.0, 100.0)
        return [controller.update(*step, **more)[0] for step in steps]

    gains = tuple(random.uniform(0.1, 3.0) for _ in range(3))
    steps = [(random.uniform(0.0, 9.0), random.uniform(0.0, 9.0), 0.05) for _ in range(4)]
    return {
        "other": run(gains, steps, feed_forward=random.uniform(-1.0, 1.0)),
        "proportional": run((2.0,), [(5.0, 2.0, 0.1)]),
        "integral": run((0.0, 0.5), [(3.0, 1.0, 0.1)] * 3),
        "derivative": run((0.0, 0.0, 1.0), [(0.0, 1.0, 0.1), (0.0, 1.5, 0.1)]),
        "feed_forward": run((1.0,), [(2.0, 2.0, 0.1)], feed_forward=0.7),
        "all": run((2.0, 0.5, 0.1), [(5.0, 2.0, 0.1), (5.0, 2.2, 0.1)], feed_forward=0.3),
    }


def stanley(random: Random) -> dict:
    """Return wheel angles; "ZeroDivisionError" where the law divides by zero."""
    from sdc_package.steering.stanley import stanley_angle

    def angle(*arguments: float) -> float | str:
        try:
            return stanley_angle(*arguments)
        except ZeroDivisionError:
            return "ZeroDivisionError"

    ranges = ((-0.5, 0.5), (-2.0, 2.0), (1.0, 20.0), (0.5, 4.0), (0.0, 2.0))
    return {
        "other": [angle(*(random.uniform(*limits) for limits in ranges)) for _ in range(4)],
        "heading": angle(0.2, 0.0, 5.0, 2.5),
        "left": angle(0.0, 0.5, 5.0, 2.5),
        "right": angle(0.0, -0.5, 5.0, 2.5),
        "slow": angle(0.0, 0.5, 1.0, 2.5),
        "stronger": angle(0.0, 0.5, 5.0, 5.0),
        "softened": angle(0.0, 0.5, 5.0, 2.5, 2.0),
        "both": angle(0.1, 0.5, 5.0, 2.5, 1.0),
        "standstill_on_path": angle(0.0, 0.0, 0.0, 2.5),
        "standstill": angle(0.0, 0.5, 0.0, 2.5),
    }


def odometry(random: Random) -> dict:
    """Return yaws of quaternions, and speeds of velocities."""
    from sdc_package.odometry import pose_and_speed, yaw_from_quaternion

    def quaternion(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> SimpleNamespace:
        cy, sy, cp, sp, cr, sr = (
            f(angle / 2) for angle in (yaw, pitch, roll) for f in (math.cos, math.sin)
        )
        return SimpleNamespace(
            w=cr * cp * cy + sr * sp * sy,
            x=sr * cp * cy - cr * sp * sy,
            y=cr * sp * cy + sr * cp * sy,
            z=cr * cp * sy - sr * sp * cy,
        )

    def speed(x: float, y: float) -> float:
        pose = SimpleNamespace(
            position=SimpleNamespace(x=1.0, y=2.0, z=0.0), orientation=quaternion(0.0)
        )
        twist = SimpleNamespace(linear=SimpleNamespace(x=x, y=y, z=0.0))
        message = SimpleNamespace(
            pose=SimpleNamespace(pose=pose), twist=SimpleNamespace(twist=twist)
        )
        return pose_and_speed(message)[3]

    yaws = (0.0, 0.5, 1.5, 2.8, -0.5, -1.5, -2.8)
    velocities = ((3.0, 4.0), (-3.0, 0.0), (0.0, -2.0), (0.0, 0.0))
    other = [random.uniform(-1.5, 1.5) for _ in range(4)]
    return {
        "other": [
            *(yaw_from_quaternion(quaternion(yaw, 0.1 * yaw)) for yaw in other),
            *(speed(9.0 * x, 5.0 * y) for x, y in zip(other, other[1:])),
        ],
        "yaws": [yaw_from_quaternion(quaternion(yaw)) for yaw in yaws],
        "tilted": yaw_from_quaternion(quaternion(0.6, 0.2, -0.1)),
        "speeds": [speed(*velocity) for velocity in velocities],
    }


def waypoint_search(random: Random) -> dict:
    """Return the nearest waypoints of some points, and which are behind a car."""
    import numpy as np

    from sdc_package.waypoint_search import WaypointSearch

    search = WaypointSearch(
        np.array(
            [(0.0, 0.0), (1.0, 0.0), (2.0, 0.5), (3.0, 1.5), (3.5, 3.0), (3.5, 4.5), (2.5, 6.0)]
        )
    )
    row = WaypointSearch(np.array([(float(i), 0.5 * i) for i in range(200)]))
    other = [random.uniform(5.0, 190.0) for _ in range(6)]
    points = [(0.1, -0.2), (2.9, 1.2), (3.7, 4.4), (2.4, 6.5), (3.6, 2.8), (-0.6, 0.3)]
    return {
        "other": [
            *(row.nearest(x, 0.5 * x + random.uniform(-0.2, 0.2)) for x in other),
            *(int(bool(row.is_behind(int(x), x + 0.5 - round(x % 1), 0.5 * x))) for x in other),
        ],
        "nearest": [search.nearest(*point) for point in points],
        "behind": [bool(search.is_behind(1, x, 0.1)) for x in (0.6, 1.4)]
        + [bool(search.is_behind(4, 3.5, y)) for y in (2.6, 3.4)],
    }


def plain(value: object) -> object:
    """Return a value that JSON can hold: a NumPy number as a plain one, all else as text."""
    if getattr(value, "size", None) == 1 and hasattr(value, "item"):
        return value.item()
    return str(value)


PROBES = {
    **{probe.__name__: probe for probe in (lane_filter, pid, stanley, odometry, waypoint_search)},
    **LOCALIZATION_PROBES,
    **PERCEPTION_PROBES,
}

if __name__ == "__main__":
    print(json.dumps(PROBES[sys.argv[1]](Random(sys.argv[2])), default=plain))
