"""A small network for the lab: two lanes to the east, and a road from the north that crosses them.

north_0 has right of way:        |
                                 v
west_1 ------------------------> : -------------------> east_1
west_0 ------------------------> : -------------------> east_0
                                 v
                              south_0
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from sdc_map.network import Network, RoadLane

WIDTH_M = 3.5
LINE_M = 300.0  # the junction begins with the line at which the car gives way
BEHIND_M = 314.0  # end of the junction
END_M = 700.0  # end of the road
SIDE_M = LINE_M + 7.0  # place of the middle of the side road
SIDE_FROM_M = 250.0  # length of the side road on each side of the road
MAIN_MPS = 14.0  # speed limit of the road
SIDE_MPS = 12.0  # speed limit of the side road
# The lanes to the east from right to left, each with its parts in order.
ROAD = (("west_0", ":j_0_0", "east_0"), ("west_1", ":j_0_1", "east_1"))
SIDE = ("north_0", ":j_2_0", "south_0")


class GiveWayLine(NamedTuple):
    """A line at which the car gives way: its place on the road, and where it meets another way."""

    line_m: float
    meets_m: float
    space_m: tuple[float, float]  # centre of the space that both need


LINES = (GiveWayLine(LINE_M, SIDE_M, (SIDE_M, 0.0)),)


def _lane(name: str, points: list, speed_mps: float, successors: tuple = ()) -> RoadLane:
    return RoadLane(name, np.array(points, float), WIDTH_M, speed_mps, successors=successors)


@lru_cache(maxsize=1)
def crossing_road() -> Network:
    """Return the network: x to the east, y to the north, the right lane at y = 0."""
    lanes = []
    for number, (before, inside, after) in enumerate(ROAD):
        y = number * WIDTH_M
        # A car in the right lane may also turn right.
        following = (":j_1_0", inside) if number == 0 else (inside,)
        lanes += [
            _lane(before, [(0, y), (LINE_M, y)], MAIN_MPS, successors=following),
            _lane(inside, [(LINE_M, y), (BEHIND_M, y)], MAIN_MPS, successors=(after,)),
            _lane(after, [(BEHIND_M, y), (END_M, y)], MAIN_MPS),
        ]
    side = [(SIDE_M, SIDE_FROM_M), (SIDE_M, WIDTH_M + 7.0), (SIDE_M, -7.0), (SIDE_M, -SIDE_FROM_M)]
    turn = [(LINE_M, 0.0), (LINE_M + 5.0, -2.0), (SIDE_M, -7.0)]
    lanes += [
        _lane(SIDE[0], side[:2], SIDE_MPS, successors=SIDE[1:2]),
        _lane(SIDE[1], side[1:3], SIDE_MPS, successors=SIDE[2:]),
        _lane(SIDE[2], side[2:], SIDE_MPS),
        _lane(":j_1_0", turn, SIDE_MPS, successors=SIDE[2:]),
    ]
    return Network("lab", lanes)
