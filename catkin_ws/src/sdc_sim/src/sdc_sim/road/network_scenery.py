"""Trees, buildings and signs beside the streets of a network."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from sdc_map.network import STOP, YIELD, Network, RoadLane
from sdc_map.network_file import load_network
from sdc_sim.road.road import MARGIN_M
from sdc_sim.road.scenery import (
    PRIORITY_SIGN,
    SIGN,
    STOP_SIGN,
    TREE,
    YIELD_SIGN,
    Scenery,
    chosen,
    generate_scenery,
)

_SLOT_M = 11.0
_STEP_M = 1.0
_SIGN_M = (0.08, 0.65, 2.6)  # length, width and height
_BESIDE_M = 0.75  # from the edge of a lane to the middle of a sign
# Beside a road whose limit is higher, such as a motorway, there are trees and no buildings:
_TOWN_LIMIT_MPS = 85.0 / 3.6
_TO_BUILDINGS_M = 60.0  # from the middle of its lanes to the middle of the nearest building


def of_map(path: str) -> Scenery:
    """Return the scenery of a map, as the camera shows it."""
    return network_scenery(load_network(path), 0)


def network_scenery(network: Network, seed: int) -> Scenery:
    """Return trees, buildings and signs beside the outer lanes, none on a lane.

    No building is near a motorway or another fast road.
    """
    y_sign, network = network.y_sign, network.right_hand
    outer = [lane for lane in network.driving if not lane.junction and not lane.right]
    ends_m = np.cumsum([lane.length_m for lane in outer])
    half_m = 0.5 * max(lane.width_m for lane in network.driving)

    def at(s_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        numbers = np.minimum(np.searchsorted(ends_m, s_m), len(outer) - 1)
        points, left = np.empty((len(s_m), 2)), np.empty((len(s_m), 2))
        for number in np.unique(numbers):
            rows, lane = numbers == number, outer[number]
            s = np.clip(s_m[rows] - ends_m[number] + lane.length_m, 0.0, lane.length_m)
            step = lane.at(s + 0.5) - lane.at(s - 0.5)
            step /= np.maximum(np.hypot(*step.T), 1e-9)[:, None]
            points[rows], left[rows] = lane.at(s), np.column_stack([-step[:, 1], step[:, 0]])
        return points, left

    samples = [
        lane.at(np.arange(0.0, lane.length_m + _STEP_M, _STEP_M)) for lane in network.driving
    ]
    tree = cKDTree(np.vstack([*samples, *network.bays]))

    def on_road(points_m: np.ndarray, margin_m: float) -> np.ndarray:
        return tree.query(points_m)[0] < half_m + MARGIN_M + margin_m

    edge_m = half_m + MARGIN_M
    slots = np.arange(0.0, ends_m[-1], _SLOT_M)
    beside = generate_scenery(at, slots, (-edge_m, edge_m), on_road, seed)
    lanes = zip(network.driving, samples)
    fast = [points for lane, points in lanes if lane.speed_limit_mps > _TOWN_LIMIT_MPS]
    if fast:
        is_near = cKDTree(np.vstack(fast)).query(beside.position_m)[0] < _TO_BUILDINGS_M
        beside = chosen(beside, np.flatnonzero(~is_near | (beside.kind == TREE)))
    columns = zip(vars(beside).values(), _signs(network))
    kind, position_m, yaw_rad, *others = (np.concatenate(pair) for pair in columns)
    return Scenery(kind, position_m * (1.0, y_sign), y_sign * yaw_rad, *others)


def _signs(network: Network) -> tuple[np.ndarray, ...]:
    """Return the columns of the signs: right of way before junctions, and limits that change."""
    placed: list[tuple[float, float, float, int]] = []

    def place(lane: RoadLane, s_m: float, number: int) -> None:
        s_m = min(max(s_m, 0.0), lane.length_m)
        (x, y), heading = lane.at(np.array([s_m]))[0], lane.heading_at(s_m)
        right_m = 0.5 * lane.width_m + _BESIDE_M
        x, y = x + right_m * np.sin(heading), y - right_m * np.cos(heading)
        placed.append((x, y, heading + np.pi, number))

    for junction in network.junctions.values():
        ways = [way for way in junction.connections if way.signal < 0]
        lines = {way.start: way.line for way in ways if way.line}
        # Where ways neither part nor meet there is a crosswalk, or one lane more or less.
        starts, ends = {way.start for way in ways}, {way.end for way in ways}
        meet = len(ways) > min(len(starts), len(ends))
        for name in starts if lines and meet else ():
            lane = network.lanes[name]
            if not lane.right and lane.length_m > 20.0:
                by_line = {STOP: STOP_SIGN, YIELD: YIELD_SIGN}
                place(lane, lane.length_m - 1.0, by_line.get(lines.get(name, ""), PRIORITY_SIGN))
    for lane in network.driving:
        if lane.junction or lane.right or lane.length_m < 20.0:
            continue
        connectors = [network.lanes[name] for name in lane.predecessors]
        before = {name for connector in connectors for name in connector.predecessors}
        limits_mps = [network.lanes[name].speed_limit_mps for name in before]
        if any(abs(limit_mps - lane.speed_limit_mps) > 0.5 for limit_mps in limits_mps):
            place(lane, 4.0, round(3.6 * lane.speed_limit_mps))
    rows = np.array(sorted(placed), float).reshape(-1, 4)
    kind = np.full(len(rows), SIGN)
    size = np.tile(_SIGN_M, (len(rows), 1))
    return kind, rows[:, :2], rows[:, 2], size, rows[:, 3].astype(int)
