"""The score of a proposal: its progress, less what it costs by a table of terms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Mapping, Sequence

import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_map.crossings import OVER_M
from sdc_package.behaviour.junctions import Claim, taken_s
from sdc_package.behaviour.offset_path import SAME_M
from sdc_package.behaviour.predict import STEP_S, TIMES_S, Predicted
from sdc_package.behaviour.propose import KEEP, NEW_WAY, Proposal
from sdc_package.behaviour.road import BEHIND_LINE
from sdc_package.behaviour.scene import StreetScene
from sdc_package.behaviour.simulate import Simulated
from sdc_package.named import load_named

# What each term counts; the section `score` of config/street_planner.yaml has the weights.
TERMS: Mapping[str, str] = {
    "contact": "a contact that it causes, less the later it is",
    "late_contact": "a contact that the car can still brake for, divided by its time",
    "right_of_way": "each second of the space of a junction that is taken from another",
    "blocks_junction": "it comes to rest in a junction",
    "crosswalk": "it drives over a crosswalk that is in use",
    "braking": "each m/s² of braking beyond the usual",
    "oncoming": "each second on the oncoming lane",
    "solid_line": "it crosses a solid line",
    "beside": "the share of the next seconds beside the route",
    "new_way": "another way than before; half of it for one back to the route",
    "hinders": "the share of the way of an ambulance that is taken",
}

# A car that is so slow when the simulation ends comes to rest there [m/s].
_RESTS_MPS = 2.0


@dataclass(frozen=True)
class Scored:
    """Scores of P proposals, and why.

    Attributes:
        terms: cost of each term (P,) [m]
        progress_m: (P,) what the car gains: its way, and its speed at the end for a second more [m]
        met: (P,) row of the prediction with the contact that costs most
        takes_from: (P,) index of the claim of which most is taken
    """

    terms: Mapping[str, np.ndarray]
    progress_m: np.ndarray
    met: np.ndarray
    takes_from: np.ndarray

    def separates(self, better: int, worse: int) -> tuple[str, float]:
        """Return what separates two proposals most: a term or "progress", and how much [m]."""
        gains_m = {name: float(costs[worse] - costs[better]) for name, costs in self.terms.items()}
        gains_m["progress"] = float(self.progress_m[better] - self.progress_m[worse])
        return max(gains_m.items(), key=lambda gain: gain[1])

    @property
    def value_m(self) -> np.ndarray:
        """The scores (P,), the greatest is the best [m]."""
        return self.progress_m - sum(self.terms.values())


Score = Callable[
    [StreetScene, Sequence[Proposal], Simulated, Sequence[Claim], Predicted],
    Scored,
]


def load_score(named: str | Score) -> Score:
    """Return a score of your own, which is called as `score` is.

    Args:
        named: the function, or `module:name` of a function or class; "" for `score`

    Raises:
        ValueError: it cannot be loaded; the message is one line with the fix
    """
    if not named:
        return score
    text = f"score_function '{named}'"
    found: Any = load_named(text, named) if isinstance(named, str) else named
    found = found() if isinstance(found, type) else found
    if not callable(found):
        raise ValueError(f"{text} is not a function, and has no __call__")
    return found


def score(
    scene: StreetScene,
    proposals: Sequence[Proposal],
    result: Simulated,
    claims: Sequence[Claim],
    others: Predicted,
) -> Scored:
    """Score proposals.

    Args:
        scene: the scene
        proposals: the proposals
        result: what becomes of each
        claims: those with right of way in the next junctions
        others: what others may do
    """
    counts = {name: np.zeros(len(proposals)) for name in TERMS}
    counts["contact"], counts["late_contact"], met = _contacts(scene, proposals, result, others)
    taken = np.array([taken_s(scene, result.s_m, claim) for claim in claims])
    taken = taken.reshape(-1, len(proposals))
    counts["right_of_way"] = taken.max(axis=0, initial=0.0)
    takes_from = taken.argmax(axis=0) if len(claims) else np.full(len(proposals), -1)
    end_m, rests = result.s_m[-1], result.speed_mps[-1] < _RESTS_MPS
    front_m = scene.settings.front_m
    for crossing in scene.crossings:
        line_m = crossing.line_m + OVER_M - front_m
        inside = (end_m > line_m) & (end_m < crossing.end_m + front_m)
        counts["blocks_junction"] += rests & inside & (scene.s_m < line_m)
    for crosswalk in scene.crosswalks:
        line_m = crosswalk.begin_m - front_m
        counts["crosswalk"] += (end_m > line_m) & (scene.s_m < line_m + OVER_M)
    usual_mps2 = scene.settings.braking_mps2
    counts["braking"] = np.maximum(result.braking_mps2 - usual_mps2, 0.0)
    counts["oncoming"] = result.oncoming_s
    counts.update(_of_ways(scene, proposals, result.way_y[:, scene.soon]))
    weights_m = scene.settings.weights_m
    terms = {name: weights_m[name] * values for name, values in counts.items()}
    progress_m = end_m - result.s_m[0] + result.speed_mps[-1]
    return Scored(terms, progress_m, met, takes_from)


def _contacts(
    scene: StreetScene, proposals: Sequence[Proposal], result: Simulated, others: Predicted
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (P,) counts of contacts, of those that are late, and the row that is met."""
    if not len(others.user):
        return np.zeros(len(proposals)), np.zeros(len(proposals)), np.full(len(proposals), -1)
    # On its own side of the road, or to return there, the car can still brake for it.
    keeps = np.array([proposal.way.name == KEEP for proposal in proposals])
    is_there = scene.way_y[scene.here] > scene.line_y[scene.here]
    may_wait = keeps & ((result.oncoming_s == 0.0) | is_there)
    stops_s = scene.speed_mps / scene.settings.braking_mps2
    late = may_wait[:, None] & (result.contact_s > stops_s)
    weight = np.where(late, 0.0, others.weight)
    sooner = weight * np.exp(-result.contact_s / TIMES_S[-1])
    late_counts = np.where(late, others.weight / np.maximum(result.contact_s, STEP_S), 0.0)
    return sooner.max(axis=1), late_counts.max(axis=1), result.contact_s.argmin(axis=1)


def _of_ways(
    scene: StreetScene, proposals: Sequence[Proposal], way_y: np.ndarray
) -> dict[str, np.ndarray]:
    """Return what (P, N) places across the road count, for lines and for whom they hinder."""
    beside_m = way_y - scene.route_y[scene.soon]
    left = scene.road.left[scene.road.at(scene.grid_m[scene.soon])]
    hinders = np.zeros(len(proposals))
    for n in scene.emergency[:1]:
        apart_m = np.abs(way_y[:, way_y.shape[1] // 2] - scene.others.y_m[n])
        hinders = np.maximum(0.0, 1.0 - apart_m / scene.body_m[n])
    return {
        "solid_line": ((beside_m > scene.inside_m) & (left == BEHIND_LINE)).any(axis=1),
        "beside": (np.abs(beside_m) > SAME_M).mean(axis=1),
        "new_way": np.array([NEW_WAY[proposal.way.name] for proposal in proposals]),
        "hinders": hinders,
    }


def name_of(user: DetectedObstacle) -> str:
    """Return what the car's reasons call a road user, such as "car 17"."""
    return f"{user.kind or 'obstacle'} {user.id}"


def because(
    scene: StreetScene,
    scored: Scored,
    result: Simulated,
    claims: Sequence[Claim],
    others: Predicted,
    best: int,
    other: int,
) -> str:
    """Return what separated a proposal from a better one, in a few words, "" if nothing did."""
    name, gain_m = scored.separates(best, other)
    if gain_m < 0.5:
        return ""
    if name in ("contact", "late_contact"):
        row = int(scored.met[other])
        user = scene.obstacles[others.user[row]]
        return f"meets {name_of(user)} after {result.contact_s[other, row]:.1f} s"
    if name == "right_of_way":
        user = scene.obstacles[claims[int(scored.takes_from[other])].number]
        return f"takes the way of {name_of(user)}"
    return f"{gain_m:.0f} m less" + ("" if name == "progress" else f" for {name}")
