"""The cost of the lab chooses on the streets of a map.

    ./drive map:=town traffic:=20 score:=sdc_behaviour.streets:score

The scene, what others may do, the proposals and their simulation are those of the car.
"""

from __future__ import annotations

from typing import Any, Sequence

import numpy as np

from sdc_behaviour.cost import LaneOutcome, cost
from sdc_package.behaviour.predict import STEP_S, TIMES_S, Predicted
from sdc_package.behaviour.propose import Proposal
from sdc_package.behaviour.score import Scored
from sdc_package.behaviour.score import score as score_of_car
from sdc_package.behaviour.simulate import Simulated

# Terms of the car that are rules.
RULES = "right_of_way", "crosswalk", "blocks_junction"
# A cost of 1 is worth so much [m].
_WORST_M = 100.0


def score(
    scene: Any,
    proposals: Sequence[Proposal],
    result: Simulated,
    claims: Sequence[Any],
    others: Predicted,
) -> Scored:
    """Score proposals by the cost of the lab; see `sdc_package.behaviour.score`."""
    scored = score_of_car(scene, proposals, result, claims, others)
    most_m = max(float(scene.top_mps), 1.0) * TIMES_S[-1]
    meets_s = np.where(others.goes_on, result.contact_s, np.inf).min(axis=1, initial=np.inf)
    costs_m = []
    for n, proposal in enumerate(proposals):
        outcome = LaneOutcome(
            collides=bool(np.isfinite(meets_s[n])),
            breaks_rule=any(scored.terms[name][n] > 0.0 for name in RULES),
            progress=min(float(result.s_m[-1, n] - result.s_m[0, n]) / most_m, 1.0),
            least_ttc_s=float(meets_s[n]),
            accelerations_mps2=np.diff(result.speed_mps[:, n]) / STEP_S,
        )
        total = cost(outcome)
        # Of what must not be, the car takes the slowest.
        is_too_fast = total >= 1.0 and proposal.share > 0.0
        costs_m.append(_WORST_M * (total + is_too_fast))
    terms = {"cost": np.array(costs_m), "new_way": scored.terms["new_way"]}
    return Scored(terms, np.zeros(len(proposals)))
