"""Cars on a motorway with a ramp, by car-following and lane-change models that Numba can compile.

Treiber, Hennecke and Helbing, "Congested traffic states in empirical observations and microscopic
simulations", Physical Review E 62, 2000 (IDM); Kesting, Treiber and Helbing, "General lane-changing
model MOBIL for car-following models", Transportation Research Record 1999, 2007.
"""

from __future__ import annotations

import numpy as np

RING_M = 1200.0  # the motorway is a ring, so that its traffic stays as dense
RAMP_M = 250.0  # length of the ramp, which is beside the start of the ring
LANE_M = 3.5  # width of a lane
LENGTH_M = 4.7  # of a car
WIDTH_M = 2.0
HORIZON_M = 100.0  # no car farther away is seen
# Rows of the cars: along the ring, speed, offset from the right lane, lane (0 is the ramp), wished
# speed, time gap. The last car is our own.
S, SPEED, Y, LANE, WISH, TIME_GAP = range(6)
_ACCELERATION, _BRAKING, _HARDEST, _GAP_M = 1.5, 2.0, 8.0, 2.0
_ROOT = 2.0 * (_ACCELERATION * _BRAKING) ** 0.5
_POLITENESS = 0.3  # share of the others' advantage in MOBIL
_LEAST = 0.2  # least advantage of a change of lane [m/s2]
_SAFE = 3.0  # hardest braking of the car behind after a change of lane [m/s2]
_SIDEWARDS_MPS = 1.0  # speed of a change of lane
_EVERY = 10  # ticks between two decisions about a change of lane
_REACH_M = 0.5 * (LANE_M + WIDTH_M) - 0.3  # a car within it of the middle of a lane is in its way


def is_in(car: np.ndarray, k: int, lane: int) -> bool:
    """Return whether car k is in the way of others in a lane."""
    return car[LANE, k] == lane or abs(car[Y, k] - LANE_M * (lane - 1)) < _REACH_M


def acceleration(car: np.ndarray, k: int, leader: int) -> float:
    """Return the acceleration of car k behind another one, -1 for none (IDM) [m/s2]."""
    share = car[SPEED, k] / car[WISH, k]
    value = 1.0 - share * share * share * share
    if leader >= 0:
        gap_m = max((car[S, leader] - car[S, k]) % RING_M - LENGTH_M, 0.1)
        closing_mps = car[SPEED, k] - car[SPEED, leader]
        wanted_m = car[SPEED, k] * (car[TIME_GAP, k] + closing_mps / _ROOT)
        value -= ((_GAP_M + max(wanted_m, 0.0)) / gap_m) ** 2
    return max(_ACCELERATION * value, -_HARDEST)


def advantage(
    car: np.ndarray, k: int, lane: int, present_mps2: float, ahead: np.ndarray, behind: np.ndarray
) -> float:
    """Return what a change of car k to a lane is worth, -1 if it is not safe (MOBIL) [m/s2]."""
    leader, follower = ahead[k, lane], behind[k, lane]
    own, others = acceleration(car, k, leader) - present_mps2, 0.0
    if leader >= 0 and (car[S, leader] - car[S, k]) % RING_M < LENGTH_M + _GAP_M:
        return -1.0
    if follower >= 0:
        pressed = acceleration(car, follower, k)
        if pressed < -_SAFE or (car[S, k] - car[S, follower]) % RING_M < LENGTH_M + _GAP_M:
            return -1.0
        others += pressed - acceleration(car, follower, leader)
    last = behind[k, int(car[LANE, k])]
    if last >= 0:
        freed = acceleration(car, last, ahead[k, int(car[LANE, k])])
        others += freed - acceleration(car, last, k)
    return own + _POLITENESS * others


def sort_along(car: np.ndarray, row: np.ndarray) -> None:
    """Sort the numbers of the cars along the ring, from the first one; changed in place."""
    for i in range(1, len(row)):  # insertion sort: in a tick, the order hardly changes
        k, j = row[i], i
        while j > 0 and car[S, row[j - 1]] < car[S, k]:
            row[j] = row[j - 1]
            j -= 1
        row[j] = k


def find_neighbours(
    car: np.ndarray, row: np.ndarray, ahead: np.ndarray, behind: np.ndarray
) -> None:
    """Find the car ahead of each car, and the car behind it, in each lane.

    Args:
        car: rows of the cars of a world
        row: the cars along the ring, from the first one
        ahead: (cars, lanes) receives the numbers of those ahead, -1 for none
        behind: (cars, lanes) receives the numbers of those behind, -1 for none
    """
    count, lanes = ahead.shape
    before, after = np.full(lanes, -1), np.full(lanes, -1)
    for i in range(2 * count):  # twice round the ring: the first car follows the last one
        k, j = row[i % count], row[count - 1 - i % count]
        for lane in range(lanes):
            ahead[k, lane], behind[j, lane] = before[lane], after[lane]
            if is_in(car, k, lane):
                before[lane] = k
            if is_in(car, j, lane):
                after[lane] = j


def change_lane(
    car: np.ndarray, tick: int, values: np.ndarray, ahead: np.ndarray, behind: np.ndarray
) -> None:
    """Let the first car with an advantage begin to change lanes, one car in a tick.

    Args:
        car: rows of the cars of a world; changed in place
        tick: number of the tick
        values: (cars,) acceleration of each car in its lane [m/s2]
        ahead: see find_neighbours
        behind: see find_neighbours
    """
    count, lanes = ahead.shape
    for k in range(count - 1):
        lane = int(car[LANE, k])
        if (tick + k) % _EVERY or car[Y, k] != LANE_M * (lane - 1):
            continue
        for other in (lane + 1, lane - 1):
            if 0 < other < lanes and advantage(car, k, other, values[k], ahead, behind) > _LEAST:
                car[LANE, k] = other
                return


def move_others(
    cars: np.ndarray,
    order: np.ndarray,
    lanes: int,
    ticks: np.ndarray,
    tick_s: float,
    first: int,
    last: int,
) -> None:
    """Move all cars but our own, the last one, for a tick.

    Args:
        cars: (N, 6, cars) rows of the cars of each world; changed in place
        order: (N, cars) the cars along the ring, from the first one; changed in place
        lanes: number of lanes with the ramp
        ticks: (N,) number of the tick of each world
        tick_s: length of a tick [s]
        first: first world to move
        last: the world after the last one to move
    """
    count = cars.shape[2]
    ahead, behind = np.empty((count, lanes), np.int64), np.empty((count, lanes), np.int64)
    values = np.empty(count)
    for world in range(first, last):
        car = cars[world]
        sort_along(car, order[world])
        find_neighbours(car, order[world], ahead, behind)
        for k in range(count - 1):
            values[k] = acceleration(car, k, ahead[k, int(car[LANE, k])])
        change_lane(car, ticks[world], values, ahead, behind)
        for k in range(count - 1):
            car[SPEED, k] = max(car[SPEED, k] + values[k] * tick_s, 0.0)
            car[S, k] = (car[S, k] + car[SPEED, k] * tick_s) % RING_M
            side_m = LANE_M * (car[LANE, k] - 1) - car[Y, k]
            car[Y, k] += min(max(side_m, -_SIDEWARDS_MPS * tick_s), _SIDEWARDS_MPS * tick_s)


def look_around(
    cars: np.ndarray, near: np.ndarray, hits: np.ndarray, first: int, last: int
) -> None:
    """Find what is around our car in some worlds.

    Args:
        cars: see move_others
        near: (N, lanes, 4) receives, for each lane, the free distance to the car ahead [m] and its
            relative speed [m/s], then the same behind
        hits: (N,) receives whether our car touches another one
        first: first world
        last: the world after the last one
    """
    own = cars.shape[2] - 1
    for world in range(first, last):
        car, found, hit = cars[world], near[world], False
        found[:, 0::2] = HORIZON_M
        found[:, 1::2] = 0.0
        for k in range(own):
            along_m = (car[S, k] - car[S, own] + 0.5 * RING_M) % RING_M - 0.5 * RING_M
            free_m = abs(along_m) - LENGTH_M
            if free_m < HORIZON_M:
                hit |= free_m < 0.0 and abs(car[Y, k] - car[Y, own]) < WIDTH_M
                side = 0 if along_m >= 0.0 else 2
                for lane in range(near.shape[1]):
                    if free_m < found[lane, side] and is_in(car, k, lane):
                        found[lane, side] = free_m
                        found[lane, side + 1] = car[SPEED, k] - car[SPEED, own]
        hits[world] = hit
