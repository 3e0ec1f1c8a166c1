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

_CAR_RESTS_MPS = 0.05  # a slower car is at rest
_OTHER_RESTS_MPS = 0.005  # a slower road user is at rest
_BEHIND_RAD = math.radians(150.0)  # least direction, from the rear axle, of a body that is behind
_REAR_AXLE = 0.3  # distance of the rear axle behind the centre, as a share of the length
_STEP_S = 0.01  # step in which the motion of the last tick is continued up to the contact
_LONGEST_S = 1.0  # longest time for which that motion is continued
_CONTACT_M = 0.1  # gap of a contact
_LANE_M = 2.5  # lanes are searched within this distance
_BUMPER_M = 0.05


def is_at_fault(network: Network, car: Sequence, other: Sequence) -> bool:
    """Return whether the car is at fault for a collision.

    Args:
        network: the streets
        car: (time [s], `RoadUser`) of the ticks before the collision, in order
        other: the same of the other road user; an unknown one counts as at rest
    """
    if not car or car[-1][1].speed_mps <= _CAR_RESTS_MPS:
        return False
    if not other or other[-1][1].speed_mps <= _OTHER_RESTS_MPS:
        return True
    car_body, other_body = _at_contact(car, other)
    c, s = math.cos(car_body.yaw_rad), math.sin(car_body.yaw_rad)
    x, y = other_body.x_m - car_body.x_m, other_body.y_m - car_body.y_m
    ahead_m, left_m = c * x + s * y, c * y - s * x
    if abs(math.atan2(left_m, ahead_m + _REAR_AXLE * car_body.length_m)) > _BEHIND_RAD:
        return False
    front_m = 0.5 * car_body.length_m
    bumper = car_body._replace(x_m=car_body.x_m + c * front_m, y_m=car_body.y_m + s * front_m)
    if overlap(bumper._replace(length_m=_BUMPER_M), other_body.grown(_CONTACT_M)):
        return True
    return not _is_within_one_lane(network, car_body)


def _at_contact(car: Sequence, other: Sequence) -> tuple[Rectangle, Rectangle]:
    for step in range(round(_LONGEST_S / _STEP_S)):
        car_body, other_body = _after(car, step * _STEP_S), _after(other, step * _STEP_S)
        if overlap(car_body, other_body.grown(_CONTACT_M)):
            return car_body, other_body
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
    near += [network.lanes[name] for name in (*lane.predecessors, *lane.successors)]
    return all(
        any(lane.line.nearest(*corner).distance_m <= 0.5 * lane.width_m for lane in near)
        for corner in body.corners()
    )
