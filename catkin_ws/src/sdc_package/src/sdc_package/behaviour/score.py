"""The score of a proposal: its progress, less what it costs by a table of terms.

The section `score` of config/street_planner.yaml has the terms and their weights.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Mapping, Sequence

import numpy as np

from sdc_map.crossings import OVER_M
from sdc_package.behaviour.junctions import Claim, taken_s
from sdc_package.behaviour.offset_path import SAME_M
from sdc_package.behaviour.predict import STEP_S, TIMES_S, Predicted
from sdc_package.behaviour.propose import KEEP, Proposal
from sdc_package.behaviour.road import BEHIND_LINE
from sdc_package.behaviour.scene import StreetScene
from sdc_package.behaviour.simulate import Simulated
from sdc_package.named import load_named

# A car that is so slow when the simulation ends comes to rest there [m/s].
_RESTS_MPS = 2.0


@dataclass(frozen=True)
class Scored:
    """Scores of P proposals, and why.

    Attributes:
        terms: cost of each term (P,) [m]
        progress_m: (P,) what the car gains: its way, and its speed at the end for a second more [m]
    """

    terms: Mapping[str, np.ndarray]
    progress_m: np.ndarray

    def separates(self, better: int, worse: int) -> tuple[str, float]:
        """Return what separates two proposals most: a term or "progress", and how much [m]."""
        gains_m = {name: float(costs[worse] - costs[better]) for name, costs in self.terms.items()}
        gains_m["progress"] = float(self.progress_m[better] - self.progress_m[worse])
        return max(gains_m.items(), key=lambda gain: gain[1])

    @property
    def value_m(self) -> np.ndarray:
        """The scores (P,), the greatest is the best [m]."""
        return self.progress_m - sum(self.terms.values())


# Scores proposals; see `score`.
Score = Callable[..., Scored]


def load_score(named: str | Score) -> Score:
    """Return a score: a function, or `module:name` of a function or class; `score` for "".

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
    """Score proposals, by what becomes of each among what others may do.

    The claims are those of road users with right of way in the next junctions.
    """
    settings, weights_m = scene.settings, scene.settings.weights_m
    counts = {name: np.zeros(len(proposals)) for name in weights_m}
    # On its own side of the road, or to return there, the car can still brake for a late contact.
    keeps = np.array([proposal.way.name == KEEP for proposal in proposals])
    is_there = scene.way_y[scene.here] > scene.line_y[scene.here]
    may_wait = keeps & ((result.oncoming_s == 0.0) | is_there)
    late = may_wait[:, None] & (result.contact_s > scene.speed_mps / settings.braking_mps2)
    soon = np.where(late, 0.0, others.weight * np.exp(-result.contact_s / TIMES_S[-1]))
    later = np.where(late, others.weight / np.maximum(result.contact_s, STEP_S), 0.0)
    counts["contact"] = soon.max(axis=1, initial=0.0)
    counts["late_contact"] = later.max(axis=1, initial=0.0)
    counts["right_of_way"] = taken_s(scene, result.s_m, claims).max(axis=0, initial=0.0)
    end_m, rests = result.s_m[-1], result.speed_mps[-1] < _RESTS_MPS
    for crossing in scene.crossings:
        line_m = crossing.line_m + OVER_M - settings.front_m
        inside = (end_m > line_m) & (end_m < crossing.end_m + settings.front_m)
        counts["blocks_junction"] += rests & inside & (scene.s_m < line_m)
    for crosswalk in scene.crosswalks:
        line_m = crosswalk.begin_m - settings.front_m
        counts["crosswalk"] += (end_m > line_m) & (scene.s_m < line_m + OVER_M)
    counts["braking"] = np.maximum(result.braking_mps2 - settings.braking_mps2, 0.0)
    counts["oncoming"] = result.oncoming_s
    way_y = result.way_y[:, scene.soon]
    beside_m, is_solid = way_y - scene.route_y[scene.soon], scene.left[scene.soon] == BEHIND_LINE
    counts["solid_line"] = ((beside_m > scene.inside_m) & is_solid).any(axis=1)
    counts["beside"] = (np.abs(beside_m) > SAME_M).mean(axis=1)
    counts["new_way"] = np.array([proposal.way.new for proposal in proposals])
    for n in scene.emergency[:1]:
        apart_m = np.abs(way_y[:, way_y.shape[1] // 2] - scene.others.y_m[n])
        counts["hinders"] = np.maximum(0.0, 1.0 - apart_m / scene.body_m[n])
    terms = {name: weights_m[name] * values for name, values in counts.items()}
    return Scored(terms, end_m - result.s_m[0] + result.speed_mps[-1])
