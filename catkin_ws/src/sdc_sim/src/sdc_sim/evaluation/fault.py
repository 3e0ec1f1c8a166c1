"""Whether a collision is the fault of the car, by the definition of nuPlan's metrics.

nuplan-devkit, `no_ego_at_fault_collisions.py`: a collision is the car's fault with one at rest,
with the front bumper, or with a side while the car is not within one lane. It is not while the car
is at rest, or if the other one comes from behind.
"""

from __future__ import annotations

import math
from typing import Any, Sequence

from sdc_map.network import Network
from sdc_sim.physics.collision import Rectangle, overlap

# Who is slower is at rest, the car and another one [m/s].
_CAR_RESTS_MPS, _OTHER_RESTS_MPS = 0.05, 0.005
# One is behind if it is in this direction from the rear axle, which is a share of the length behind
# the centre.
_BEHIND_RAD, _REAR_AXLE = math.radians(150.0), 0.3
# The motion of the last tick is continued in these steps up to the contact [s], at this gap [m].
_STEP_S, _LONGEST_S, _CONTACT_M = 0.01, 1.0, 0.1
_LANE_M, _BUMPER_M = 2.5, 0.05


def is_at_fault(network: Network, car: Sequence, other: Sequence) -> bool:
    """Return whether the car is at fault for a collision.

    Args:
        network: the streets
        car: (time [s], `RoadUser`) of the ticks before the collision, in order
        other: the same of the other one; one that is not known counts as one at rest
    """
    if not car or car[-1][1].speed_mps <= _CAR_RESTS_MPS:
        return False
    if not other or other[-1][1].speed_mps <= _OTHER_RESTS_MPS:
        return True
    mine, theirs = _at_contact(car, other)
    c, s = math.cos(mine.yaw_rad), math.sin(mine.yaw_rad)
    x, y = theirs.x_m - mine.x_m, theirs.y_m - mine.y_m
    ahead_m, left_m = c * x + s * y, c * y - s * x
    if abs(math.atan2(left_m, ahead_m + _REAR_AXLE * mine.length_m)) > _BEHIND_RAD:
        return False
    front_m = 0.5 * mine.length_m
    bumper = mine._replace(x_m=mine.x_m + c * front_m, y_m=mine.y_m + s * front_m)
    if overlap(bumper._replace(length_m=_BUMPER_M), theirs.grown(_CONTACT_M)):
        return True
    return not _is_within_one_lane(network, mine)


def _at_contact(car: Sequence, other: Sequence) -> tuple[Rectangle, Rectangle]:
    for step in range(round(_LONGEST_S / _STEP_S)):
        mine, theirs = _after(car, step * _STEP_S), _after(other, step * _STEP_S)
        if overlap(mine, theirs.grown(_CONTACT_M)):
            return mine, theirs
    return car[-1][1].body, other[-1][1].body


def _after(trail: Sequence, time_s: float) -> Rectangle:
    """Return the outline some time after the last tick, at the velocity and turn rate of it."""
    (before_s, before), (last_s, last) = trail[-2:] if len(trail) > 1 else (trail[0], trail[0])
    share = time_s / (last_s - before_s) if last_s > before_s else 0.0
    turned = math.remainder(last.body.yaw_rad - before.body.yaw_rad, 2.0 * math.pi)
    way_m, yaw_rad = last.speed_mps * time_s, last.body.yaw_rad + share * turned
    x = last.body.x_m + way_m * math.cos(yaw_rad)
    return Rectangle(x, last.body.y_m + way_m * math.sin(yaw_rad), yaw_rad, *last.body[3:])


def _is_within_one_lane(network: Network, body: Rectangle) -> bool:
    """Return whether all corners are on the lane of the centre, or one that continues it."""
    place = network.nearest(*body[:3], _LANE_M, body.z_m)
    if place is None:
        return False
    lane = network.lanes[place.lane]
    near: list[Any] = [lane]
    near += [network.lanes[one] for one in (*lane.predecessors, *lane.successors)]
    return all(
        any(one.line.nearest(*corner).distance_m <= 0.5 * one.width_m for one in near)
        for corner in body.corners()
    )
