#!/usr/bin/env python3
"""Calls a module of the car's library with known numbers, and prints what it answers, as JSON on the last line.
Usage: library_probe.py MODULE"""

import json
import math
import sys
from types import SimpleNamespace


def lane_filter():
    from road_picture import road

    from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds

    mask = LaneFilter(LaneFilterThresholds(70, 90, 110, 0.52)).mask(road())
    if mask.shape != (480, 640):
        return {
            "shape": list(mask.shape),
            **dict.fromkeys(("white_line", "yellow_line", "sky", "asphalt"), 0),
        }
    return {
        "shape": list(mask.shape),
        "white_line": int((mask[300:, 98:112] > 0).sum()),
        "yellow_line": int((mask[300:, 303:307] > 0).sum()),
        "sky": int((mask[:249] > 0).sum()),
        "asphalt": int((mask[300:, 150:280] > 0).sum()),
    }


def pid():
    from sdc_package.pid import Pid, PidGains

    def run(gains, steps, limits=(-100.0, 100.0), **more):
        controller = Pid(PidGains(*gains), *limits)
        return [controller.update(*step, **more)[0] for step in steps]

    return {
        "proportional": run((2.0,), [(5.0, 2.0, 0.1)]),
        "integral": run((0.0, 0.5), [(3.0, 1.0, 0.1)] * 3),
        "derivative": run((0.0, 0.0, 1.0), [(0.0, 1.0, 0.1), (0.0, 1.5, 0.1)]),
        "feed_forward": run((1.0,), [(2.0, 2.0, 0.1)], feed_forward=0.7),
        "all": run((2.0, 0.5, 0.1), [(5.0, 2.0, 0.1), (5.0, 2.2, 0.1)], feed_forward=0.3),
    }


def stanley():
    from sdc_package.steering.stanley import stanley_angle

    return {
        "heading": stanley_angle(0.2, 0.0, 5.0, 2.5),
        "left": stanley_angle(0.0, 0.5, 5.0, 2.5),
        "right": stanley_angle(0.0, -0.5, 5.0, 2.5),
        "slow": stanley_angle(0.0, 0.5, 1.0, 2.5),
        "stronger": stanley_angle(0.0, 0.5, 5.0, 5.0),
        "softened": stanley_angle(0.0, 0.5, 5.0, 2.5, 2.0),
        "both": stanley_angle(0.1, 0.5, 5.0, 2.5, 1.0),
        "standing": stanley_angle(0.0, 0.0, 0.0, 2.5),
    }


def odometry():
    from sdc_package.odometry import pose_and_speed, yaw_from_quaternion

    def quaternion(yaw, pitch=0.0, roll=0.0):
        cy, sy, cp, sp, cr, sr = (
            f(angle / 2) for angle in (yaw, pitch, roll) for f in (math.cos, math.sin)
        )
        return SimpleNamespace(
            w=cr * cp * cy + sr * sp * sy,
            x=sr * cp * cy - cr * sp * sy,
            y=cr * sp * cy + sr * cp * sy,
            z=cr * cp * sy - sr * sp * cy,
        )

    def speed(x, y):
        return pose_and_speed(
            SimpleNamespace(
                pose=SimpleNamespace(
                    pose=SimpleNamespace(
                        position=SimpleNamespace(x=1.0, y=2.0, z=0.0), orientation=quaternion(0.0)
                    )
                ),
                twist=SimpleNamespace(
                    twist=SimpleNamespace(linear=SimpleNamespace(x=x, y=y, z=0.0))
                ),
            )
        )[3]

    return {
        "yaws": [
            yaw_from_quaternion(quaternion(yaw)) for yaw in (0.0, 0.5, 1.5, 2.8, -0.5, -1.5, -2.8)
        ],
        "tilted": yaw_from_quaternion(quaternion(0.6, 0.2, -0.1)),
        "speeds": [
            speed(*velocity) for velocity in ((3.0, 4.0), (-3.0, 0.0), (0.0, -2.0), (0.0, 0.0))
        ],
    }


def waypoint_search():
    import numpy as np

    from sdc_package.waypoint_search import WaypointSearch

    search = WaypointSearch(
        np.array(
            [(0.0, 0.0), (1.0, 0.0), (2.0, 0.5), (3.0, 1.5), (3.5, 3.0), (3.5, 4.5), (2.5, 6.0)]
        )
    )
    places = [(0.1, -0.2), (2.9, 1.2), (3.7, 4.4), (2.4, 6.5), (3.6, 2.8), (-0.6, 0.3)]
    return {
        "nearest": [search.nearest(*place) for place in places],
        "kinds": [type(search.nearest(*place)).__name__ for place in places[:1]],
        "behind": [bool(search.is_behind(1, x, 0.1)) for x in (0.6, 1.4)]
        + [bool(search.is_behind(4, 3.5, y)) for y in (2.6, 3.4)],
    }


def plain(value):
    """What JSON does not know: NumPy's numbers become plain ones, all else the words for it."""
    return (
        value.item() if getattr(value, "size", None) == 1 and hasattr(value, "item") else str(value)
    )


PROBES = {probe.__name__: probe for probe in (lane_filter, pid, stanley, odometry, waypoint_search)}

if __name__ == "__main__":
    print(json.dumps(PROBES[sys.argv[1]](), default=plain))
