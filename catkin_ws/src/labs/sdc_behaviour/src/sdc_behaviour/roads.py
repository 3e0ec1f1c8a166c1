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

import numpy as np

from sdc_sim.road.network import YIELD, Connection, Junction, Network, RoadLane

WIDTH_M = 3.5
# The junction, which begins with the line at which one gives way, and the end of the road [m].
LINE_M, BEHIND_M, END_M = 300.0, 314.0, 700.0
SIDE_M, SIDE_FROM_M = LINE_M + 7.0, 250.0
MAIN_MPS, SIDE_MPS = 14.0, 12.0
# The lanes to the east from right to left, each with its parts in order.
ROAD = (("west_0", ":j_0_0", "east_0"), ("west_1", ":j_0_1", "east_1"))
SIDE = ("north_0", ":j_2_0", "south_0")


def _lane(name: str, points: list, speed_mps: float, successors: tuple = ()) -> RoadLane:
    junction, points_m = "j" if name.startswith(":") else "", np.array(points, float)
    return RoadLane(name, points_m, WIDTH_M, speed_mps, successors=successors, junction=junction)


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
    ways = [
        Connection("north_0", (SIDE[1],), "south_0", "s"),
        *(Connection(one[0], one[1:2], one[2], "s", (0,), line=YIELD) for one in ROAD),
        Connection("west_0", (":j_1_0",), "south_0", "r", (0,), line=YIELD),
    ]
    low, high = -7.0, WIDTH_M + 7.0
    outline = np.array([(LINE_M, low), (BEHIND_M, low), (BEHIND_M, high), (LINE_M, high)])
    return Network("lab", lanes, [Junction("j", "priority", outline, tuple(ways))])
