"""Proposals of the car, simulated a few seconds ahead among the predicted others.

The car follows who is in its way by the intelligent driver model (M. Treiber, A. Hennecke and
D. Helbing, Phys. Rev. E 62, 2000). A car that is too fast brakes for the speed or for the other,
whichever needs more, not for the sum (M. Treiber and A. Kesting, Traffic Flow Dynamics, 2013,
section 11.3.7).
"""

from __future__ import annotations

import math
from itertools import compress
from typing import Any, Iterable, NamedTuple, Sequence

import numpy as np

from sdc_package.behaviour.offset_path import SAME_M
from sdc_package.behaviour.predict import STEP_S, Predicted
from sdc_package.behaviour.propose import Proposal
from sdc_package.behaviour.scene import AT_REST_MPS, GRID_M, StreetScene


class Simulated(NamedTuple):
    """What becomes of P proposals among R predicted rows, in T steps of STEP_S."""

    way_y: np.ndarray  # (P, G) place across the road on the grid of the scene [m]
    s_m: np.ndarray  # (T, P) arc length of the car's centre [m]
    speed_mps: np.ndarray  # (T, P)
    contact_s: np.ndarray  # (P, R) time of the first contact that the car would cause [s]
    braking_mps2: np.ndarray  # (P,) greatest deceleration for others and stops [m/s^2]
    oncoming_s: np.ndarray  # (P,) time on the oncoming lane [s]
    leads: np.ndarray  # (P, R) whether a road user takes half of its acceleration from the car


def simulate(scene: StreetScene, proposals: Sequence[Proposal], others: Predicted) -> Simulated:
    """Simulate proposals among the predicted others."""
    cars = _Cars(scene, proposals, others)
    s_m, speed_mps, hardest_mps2, leads = cars.driven()
    places = cars.at(s_m)
    oncoming_s = STEP_S * (cars.way_y[cars.rows, places] > scene.line_y[places]).sum(axis=0)
    contact_s = cars.contacts_s(s_m, speed_mps)
    return Simulated(cars.way_y, s_m, speed_mps, contact_s, hardest_mps2, oncoming_s, leads)


class _Cars:
    """The car on each of P proposals, among R predicted rows."""

    def __init__(self, scene: StreetScene, proposals: Sequence[Proposal], others: Predicted):
        self.scene, self.settings, self.others = scene, scene.settings, others
        self.rows = np.arange(len(proposals))
        offsets_m = {proposal.number: proposal.way.offset_m for proposal in proposals}
        ways_y = scene.ways(list(offsets_m.values()))
        numbers = [proposal.number for proposal in proposals]
        self.way_y = ways_y[numbers]
        self.its_way_y = self.way_y[self.rows[:, None], self.at(others.s_m)[:, None]]  # (T, P, R)
        bend = np.gradient(np.gradient(ways_y - scene.route_y, axis=1), axis=1) / GRID_M**2
        bends_mps = scene.way.bend_mps(bend, scene.road_bend, scene.grid_m)
        self.bend = (bend + scene.road_bend)[numbers]
        shares = np.array([[proposal.share] for proposal in proposals])
        self.most_mps = np.minimum(scene.most_mps * shares, bends_mps[numbers])
        light_m = scene.stop.s_m if scene.stop else math.inf
        self.stops_m = [min(proposal.stop_m, light_m) for proposal in proposals]
        at_rest = scene.speed_mps < AT_REST_MPS  # it has yet to begin
        self.is_new = np.array([[proposal.way.new > 0.0 or at_rest] for proposal in proposals])
        on_way = np.abs(others.y_m[0] - self.way_y[0, scene.here]) < 0.5 * self.settings.width_m
        self.moves = np.abs(others.along_mps) > AT_REST_MPS
        # Whose middle is behind the car now.
        self.follows = on_way & others.aligned & (others.s_m[0] < scene.s_m)

    def at(self, s_m: np.ndarray) -> np.ndarray:
        """Return the indices of the places on the grid at arc lengths."""
        places = ((s_m - self.scene.from_m) / GRID_M).astype(int)
        return np.minimum(np.maximum(places, 0), len(self.scene.grid_m) - 1)

    def driven(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return arc lengths and speeds (T, P), greatest decelerations, and who is ahead (P, R)."""
        others, side_m = self.others, self.settings.streets.side_m
        reach_m = others.half_width_m + np.where(self.moves, side_m, SAME_M)
        in_way = np.abs(others.y_m[:, None] - self.its_way_y) < reach_m[:, None]
        in_way &= others.goes_on & ~self.follows
        known = np.stack([others.s_m, others.half_length_m, others.along_mps], axis=-1).tolist()
        its = enumerate(in_way.transpose(1, 0, 2).tolist())
        drives = [self._driven(row, map(compress, known, is_in)) for row, is_in in its]
        s_m, mps, hardest_mps2, ratios = zip(*drives)
        leads = in_way[0].copy()
        leads[leads] = np.square(np.concatenate(ratios)) > 0.5
        return np.array(s_m).T, np.array(mps).T, np.array(hardest_mps2), leads

    def _driven(self, row: int, in_way: Iterable[Iterable[list[float]]]) -> tuple[Any, ...]:
        """Return the same of a proposal, among (place, half length, speed) of those in its way.

        Instead of who is ahead: the gap to each that the car wants, by the gap there is, 0 behind.
        In plain floats: arrays of so few proposals and road users take twice as long.
        """
        margins, braking_mps2 = self.settings.streets, self.settings.braking_mps2
        follow_m, places_mps = margins.follow_gap_m, self.most_mps[row]
        root_mps2 = 2.0 * math.sqrt(margins.acceleration_mps2 * braking_mps2)
        s_m, v = self.scene.s_m, self.scene.speed_mps
        way: list[tuple[float, float, float, list[float]]] = []
        # The stop is a road user at rest, of negative length: the car stops there or behind it.
        stop = self.stops_m[row], -follow_m, 0.0
        for users in in_way:
            gap_s = margins.time_gap_s + v / root_mps2
            ratios = [
                (follow_m + max(v * (gap_s - mps / root_mps2), 0.0)) / max(at - s_m - half, SAME_M)
                if at > s_m or half < 0.0
                else 0.0
                for at, half, mps in (stop, *users)
            ]
            wanted = max(ratios)
            pushed_mps2 = margins.acceleration_mps2 * (wanted * wanted)
            pushed_mps2 = min(pushed_mps2, 4.0 * margins.hardest_mps2)
            place = min(int((s_m - self.scene.from_m) / GRID_M), len(places_mps) - 1)
            top_mps = places_mps.item(place)
            free_mps2 = margins.acceleration_mps2 * (1.0 - (v / max(top_mps, AT_REST_MPS)) ** 4)
            way.append((s_m, v, pushed_mps2 * (v > AT_REST_MPS), ratios))
            a = min(max(free_mps2, -braking_mps2), max(free_mps2, 0.0) - pushed_mps2)
            most_mps = max(top_mps, v - STEP_S * braking_mps2)
            v_next = min(max(v + STEP_S * max(a, -margins.hardest_mps2), 0.0), most_mps)
            s_m, v = s_m + 0.5 * STEP_S * (v + v_next), v_next
        way_s, way_mps, brakes_mps2, ratios_to = zip(*way)
        return way_s, way_mps, max(brakes_mps2), ratios_to[0][1:]

    def contacts_s(self, s_m: np.ndarray, speed_mps: np.ndarray) -> np.ndarray:
        """Return (P, R) times of the first contacts that the car would cause, inf: none [s]."""
        others, margins, way_y = self.others, self.settings.streets, self.way_y
        half_length_m = others.half_length_m[:, None]
        place_y = way_y[self.rows, self.at(s_m)][..., None]
        # The front is where the centre will be; beside another, the part of the car there counts.
        front_m, distance_m = self.settings.front_m, others.s_m[:, None] - s_m[..., None]
        front_y = way_y[self.rows, self.at(s_m + front_m)][..., None]
        where = [distance_m > front_m, distance_m > -front_m]
        near_y = np.select(where, [front_y, self.its_way_y], place_y)
        # It turns about its rear axle, half way to its end: its front is outside of a bend.
        part_m = np.clip(distance_m, -front_m, front_m)
        bend = self.bend[self.rows, self.at(s_m)][..., None]
        near_y -= 0.5 * bend * part_m * (part_m + front_m)
        reach_m = others.half_width_m + np.where(self.moves, margins.side_m, 0.0)
        overlap = np.abs(others.y_m[:, None] - near_y) < reach_m[:, None]
        # A new way has greater distances, so that the car is not of two minds.
        factor = np.where(self.is_new, margins.new_factor, 1.0)
        car_mps, its_mps = speed_mps[..., None], others.along_mps[:, None]
        is_behind = overlap & others.aligned & (distance_m < 0.0)
        closing_mps = np.maximum(its_mps - car_mps, 0.0)
        safe_m = margins.gap_m + closing_mps**2 / (2.0 * margins.rear_mps2)
        cuts_in = is_behind & (-distance_m - half_length_m < factor * safe_m)
        # A car that stays in its lane does not cut in.
        cuts_in &= np.abs(place_y - way_y[0, self.scene.here]) > 2.0 * SAME_M
        is_oncoming = its_mps < -np.abs(others.left_mps)
        clear_m = np.where(is_oncoming, -margins.oncoming_s * factor * its_mps, 0.5)
        meets = overlap & (distance_m < half_length_m + clear_m)
        meets &= distance_m > -half_length_m - 0.5
        meets &= is_oncoming | (car_mps > AT_REST_MPS)
        # A road user that has been behind the car for some steps keeps its distance.
        settled = np.zeros_like(is_behind)
        settled[2:] = is_behind[2:] & is_behind[1:-1] & is_behind[:-2]
        settled = np.logical_or.accumulate(settled, axis=0) | self.follows
        contact = (cuts_in | meets) & ~settled
        return np.where(contact.any(axis=0), STEP_S * contact.argmax(axis=0), math.inf)
