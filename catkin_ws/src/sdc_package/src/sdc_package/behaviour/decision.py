"""What the car does next: propose, simulate, score, and take the best."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterator, Sequence

import numpy as np

from sdc_map.crossings import BESIDE_M, OVER_M
from sdc_package.behaviour.junctions import Claim, claims_of, taken_s
from sdc_package.behaviour.predict import STEP_S, STEPS, Predictor
from sdc_package.behaviour.propose import KEEP, Proposal, proposals, ways
from sdc_package.behaviour.scene import AT_REST_MPS, Stop, StreetScene
from sdc_package.behaviour.score import Score, Scored
from sdc_package.behaviour.simulate import simulate
from sdc_package.braking import FIRM_MPS2, HARD_MPS2

# What limits the speed, see speed_reasons of sdc_sim's config/report_page.yaml.
OBSTACLE = "obstacle"
# The same where going would cost this term.
REASONS = {
    "right_of_way": "right_of_way",
    "blocks_junction": "junction_blocked",
    "crosswalk": "crosswalk",
}


@dataclass(frozen=True)
class Decision:
    """What the car does until the next decision."""

    proposal: Proposal | None = None  # the best one, None if no one is near
    s_m: Sequence[float] = ()  # arc lengths (T,) at which the car will be, see `simulate` [m]
    # Its speeds there, none where no road user or stop is near its way [m/s].
    speed_mps: Sequence[float] = ()
    reason: str = ""  # what limits the speed, "" if nothing does
    # The two best proposals and what separated them, or whom the car follows.
    detail: str = ""
    brakes_hard: bool = False  # whether the car brakes as hard as it can
    proposals: Sequence[Proposal] = ()  # all that the car could do
    scored: Scored | None = None  # the scores of them, None without any

    @property
    def options(self) -> list[tuple[str, float, dict[str, float]]]:
        """Each proposal, its score, and the terms of it [m]."""
        if self.scored is None:
            return []
        values_m, terms = self.scored.value_m.tolist(), self.scored.terms.items()
        return [
            (str(proposal), values_m[n], {name: float(costs[n]) for name, costs in terms})
            for n, proposal in enumerate(self.proposals)
        ]

    @property
    def stop_m(self) -> float:
        """Arc length at which the centre of the car stops, inf: nowhere [m]."""
        return self.proposal.stop_m if self.proposal else math.inf


def decide(scene: StreetScene, predictor: Predictor, score: Score, keeps_route: bool) -> Decision:
    """Return what the car does next; one that keeps its route takes no other way."""
    claims, stops_m = claims_of(scene, predictor)
    others = predictor.predict(scene, stops_m)
    found = proposals([*ways(scene, keeps_route)], [*_stops(scene, claims)])
    result = simulate(scene, found, others)
    scored = score(scene, found, result, claims, others)
    best = int(np.argmax(scored.value_m))
    other = _compared(found, scored.value_m, best)
    chosen = found[best]

    def name_of(number: int) -> str:
        user = scene.obstacles[number]
        return f"{user.kind or 'obstacle'} {user.id}"

    def because(better: int, worse: int) -> str:
        """Return what separated a proposal from a better one, "" if nothing did."""
        term, gain_m = scored.separates(better, worse)
        if gain_m < 0.5:
            return ""
        if term in ("contact", "late_contact") and len(others.user):
            row = int(result.contact_s[worse].argmin())
            name, contact_s = name_of(others.user[row]), result.contact_s[worse, row]
            return f"{found[worse]}: meets {name} after {contact_s:.1f} s"
        if term == "right_of_way" and claims:
            most = int(taken_s(scene, result.s_m[:, [worse]], claims).argmax())
            return f"{found[worse]}: takes the way of {name_of(claims[most].number)}"
        of_term = "" if term == "progress" else f" for {term}"
        return f"{found[worse]}: {gain_m:.0f} m less{of_term}"

    # The best proposal still meets someone who is then ahead, before a hard stop could avoid it.
    steps = np.minimum(result.contact_s[best] / STEP_S, STEPS - 1.0).astype(int)
    ahead = others.s_m[steps, np.arange(len(steps))] > result.s_m[steps, best]
    contacts_s = np.where(others.goes_on & ahead, result.contact_s[best], math.inf)
    late_s = scene.speed_mps / (2.0 * HARD_MPS2) + STEP_S  # for a stop before the contact
    brakes_hard = contacts_s.min(initial=math.inf) < late_s
    reason, detail = _reason(scene, chosen, scored.separates(best, other)[0]), ""
    leaders = np.flatnonzero(result.leads[best])
    if brakes_hard:
        reason, detail = OBSTACLE, f"brakes hard for {name_of(others.user[contacts_s.argmin()])}"
    elif reason:
        detail = "; ".join(filter(None, (because(best, other), because(other, best))))
    elif len(leaders):
        reason, detail = OBSTACLE, name_of(others.user[leaders[others.s_m[0, leaders].argmin()]])
    # The car stops where it would become so slow; where it would wait and drive on, it stays.
    waits = np.logical_or.accumulate(np.append(False, result.speed_mps[1:, best] == 0.0))
    stops = brakes_hard | waits | (result.speed_mps[:, best] < AT_REST_MPS)
    speeds = result.s_m[:, best], np.where(stops, 0.0, result.speed_mps[:, best])
    if not (reason or len(others.user) or result.braking_mps2[best]):  # all is free
        speeds = (), ()
    return Decision(chosen, *speeds, reason, detail, bool(brakes_hard), found, scored)


def _compared(found: Sequence[Proposal], values_m: np.ndarray, best: int) -> int:
    """Return with what the best proposal is compared: with going, or else the second best."""
    chosen = found[best]
    go = next(n for n, proposal in enumerate(found) if proposal.way is chosen.way)
    if go != best:
        return go
    others = (int(n) for n in np.argsort(-values_m) if str(found[n]) != str(chosen))
    return next(others, best)


def _reason(scene: StreetScene, chosen: Proposal, term: str) -> str:
    """Return why the car does not just go: the term that going on the same way would cost."""
    if chosen.share < 1.0 or chosen.stop:
        return REASONS.get(term, "merging" if scene.changes_lane else OBSTACLE)
    if math.isfinite(chosen.stop_m):
        return OBSTACLE
    return "passing" if chosen.way.name != KEEP or scene.way.until_m else ""


def _stops(scene: StreetScene, claims: Sequence[Claim]) -> Iterator[Stop]:
    """Yield the places at which the car could stop for others, where it still can."""
    front_m, gap_m = scene.settings.front_m, scene.settings.streets.gap_m
    firm_m = scene.s_m + scene.speed_mps**2 / (2.0 * FIRM_MPS2)
    soonest_m = scene.s_m + scene.speed_mps**2 / (2.0 * scene.settings.streets.hardest_mps2)
    places = [(walk.begin_m, walk.begin_m, "crosswalk") for walk in scene.crosswalks]
    for crossing in scene.crossings:
        spaces_m = [claim.conflict.own_m[0] for claim in claims if claim.crossing is crossing]
        latest_m = max(crossing.line_m, min(spaces_m, default=0.0) - BESIDE_M)
        places.append((crossing.line_m, latest_m, "right_of_way"))
    for place_m, latest_m, reason in places:
        if soonest_m <= latest_m - front_m + OVER_M:
            # It uses the gap rather than brake hard.
            stop_m = min(latest_m - front_m, max(place_m - front_m - gap_m, firm_m))
            yield Stop(stop_m, reason)
