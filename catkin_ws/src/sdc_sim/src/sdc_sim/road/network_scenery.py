"""Trees and buildings beside the streets of a network."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from sdc_sim.road.network import Network
from sdc_sim.road.road import MARGIN_M
from sdc_sim.road.scenery import Scenery, generate_scenery

_SLOT_M = 11.0
_STEP_M = 1.0


def network_scenery(network: Network, seed: int) -> Scenery:
    """Return trees and buildings to the right of the outer lanes, none on a lane."""
    outer = [one for one in network.driving if not one.junction and not one.right]
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
    tree = cKDTree(np.vstack(samples))

    def on_road(points_m: np.ndarray, margin_m: float) -> np.ndarray:
        return tree.query(points_m)[0] < half_m + MARGIN_M + margin_m

    edge_m = half_m + MARGIN_M
    slots = np.arange(0.0, ends_m[-1], _SLOT_M)
    return generate_scenery(at, slots, (-edge_m, edge_m), on_road, seed)
