"""Keep the lane, or change it? Propose, simulate, score, choose: the recipe of PDM-Closed."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Iterable

import numpy as np

from sdc_behaviour.cost import LaneOutcome, cost
from sdc_behaviour.gaps import OnLane, time_to_collision_s
from sdc_behaviour.rss import Rss, following_mps2, safe_distance_m

HORIZON_S = 8.0  # a simulation looks this time ahead
STEP_S = 0.5  # step of a simulation
CHANGE_S = 2.0  # time for which a car that changes its lane is on both lanes


@dataclass(frozen=True)
class LaneScene:
    """What the car decides about."""

    own: OnLane  # the car; its lane is the one that it drives on, or changes to
    others: tuple[OnLane, ...] = ()  # the road users on the lanes of its road
    lanes: int = 2  # number of lanes
    limit_mps: float = 14.0  # speed limit [m/s]
    stop_m: float = math.inf  # place that the front of the car must not pass, inf without one [m]
    rss: Rss = field(default_factory=Rss)  # the worst case for which it keeps a safe distance
    # Share of the safe distance that it leaves to one behind it when it changes lanes
    politeness: float = 1.5


@dataclass(frozen=True)
class LaneProposal:
    """Drive on this lane, as fast as the one ahead allows, but no faster than this speed [m/s]."""

    lane: int
    speed_mps: float


def gap_m(rear: OnLane, front: OnLane) -> float:
    """Return the distance from bumper to bumper [m]."""
    return front.s_m - rear.s_m - 0.5 * (front.length_m + rear.length_m)


def one_ahead(own: OnLane, others: Iterable[OnLane], lanes: set[int]) -> OnLane | None:
    """Return the nearest road user ahead on some lanes, None if there is none."""
    ahead = [user for user in others if user.lane in lanes and user.s_m >= own.s_m]
    return min(ahead, key=lambda user: user.s_m) if ahead else None


def one_behind(own: OnLane, others: Iterable[OnLane], lanes: set[int]) -> OnLane | None:
    """Return the nearest road user behind on some lanes, None if there is none."""
    behind = [user for user in others if user.lane in lanes and user.s_m < own.s_m]
    return max(behind, key=lambda user: user.s_m) if behind else None


def acceleration_mps2(scene: LaneScene, wanted_mps: float, lanes: set[int]) -> float:
    """Return the acceleration that keeps the safe distance on some lanes, and stops at stop_m."""
    own, front = scene.own, one_ahead(scene.own, scene.others, lanes)
    to_stop_m = scene.stop_m - own.s_m - 0.5 * own.length_m + 0.5
    distances = [(to_stop_m, 0.0)]
    if front is not None:
        distances.append((gap_m(own, front), front.speed_mps))
    return min(
        following_mps2(own.speed_mps, gap, mps, wanted_mps, scene.rss) for gap, mps in distances
    )


def simulate(scene: LaneScene, proposal: LaneProposal) -> LaneOutcome:
    """Return what happens if the car follows a proposal, and all others keep lane and speed."""
    changes = proposal.lane != scene.own.lane
    behind = one_behind(scene.own, scene.others, {proposal.lane}) if changes else None
    pushes = behind is not None and gap_m(behind, scene.own) < scene.politeness * safe_distance_m(
        behind.speed_mps, scene.own.speed_mps, scene.rss
    )
    collides, least_ttc_s, accelerations, start_m = False, math.inf, [], scene.own.s_m
    for step in range(round(HORIZON_S / STEP_S)):
        is_changing = step * STEP_S < CHANGE_S
        lanes = {proposal.lane, scene.own.lane} if is_changing else {proposal.lane}
        a = acceleration_mps2(scene, proposal.speed_mps, lanes)
        own = scene.own
        speed = max(own.speed_mps + a * STEP_S, 0.0)
        way_m = 0.5 * (own.speed_mps + speed) * STEP_S
        own = OnLane(own.s_m + way_m, speed, own.length_m, own.lane)
        others = tuple(
            OnLane(user.s_m + user.speed_mps * STEP_S, user.speed_mps, user.length_m, user.lane)
            for user in scene.others
        )
        scene = replace(scene, own=own, others=others)
        accelerations.append(a)
        front = one_ahead(own, others, lanes)
        if front is not None:
            collides |= gap_m(own, front) < 0.0
            least_ttc_s = min(least_ttc_s, time_to_collision_s(own, front))
        if changes:
            behind = one_behind(own, others, {proposal.lane})
            if behind is not None:
                collides |= gap_m(behind, own) < 0.0
                least_ttc_s = min(least_ttc_s, time_to_collision_s(behind, own))
    progress = (scene.own.s_m - start_m) / (scene.limit_mps * HORIZON_S)
    passes = scene.own.s_m + 0.5 * scene.own.length_m > scene.stop_m
    return LaneOutcome(
        collides, pushes or passes, min(progress, 1.0), least_ttc_s, np.array(accelerations)
    )


def choose(scene: LaneScene) -> LaneProposal:
    """Return what the car does next.

    It is called twice a second, and what it returned last is in scene.own.lane. A car that
    changes its mind each time drives on the line between the lanes.
    """
    own = scene.own.lane
    # TODO 8: propose, simulate, score (until then: return LaneProposal(own, scene.limit_mps))
    proposals = [
        LaneProposal(lane, share * scene.limit_mps)
        for lane in range(max(own - 1, 0), min(own + 2, scene.lanes))
        for share in (1.0, 0.6, 0.0)
    ]

    def total(proposal: LaneProposal) -> float:
        # A change must pay; but who can, keeps right.
        changing = 0.02 * (proposal.lane != own)
        return cost(simulate(scene, proposal)) + changing + 0.02 * proposal.lane

    best = min(proposals, key=total)
    return best if total(best) < 1.0 else LaneProposal(own, 0.0)
    # ----------------------------------------------------------------------------
