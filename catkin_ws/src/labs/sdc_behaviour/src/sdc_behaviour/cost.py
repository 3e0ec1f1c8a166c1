"""What does a proposal cost? Safety and rules first, then progress and comfort.

As in PDM-Closed (Dauner, Hallgarten, Geiger, Chitta, 2023), https://arxiv.org/abs/2306.07962: what
must not be multiplies the score by 0, and what is wanted is a weighted mean.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

PROGRESS = 5.0  # weight of the progress
DISTANCE = 5.0  # weight of the time to collision
COMFORT = 2.0  # weight of comfort
LEAST_TTC_S = 1.0
# Limits of comfort of nuPlan for the acceleration along the road.
HARDEST_MPS2 = -4.05
STRONGEST_MPS2 = 2.40


@dataclass(frozen=True)
class LaneOutcome:
    """What happens in the next seconds if the car follows a proposal."""

    collides: bool  # whether it touches another road user
    breaks_rule: bool  # whether it takes the right of way, or passes a line that it must not
    progress: float  # way of the car as a share of what the limit allows, from 0 to 1
    least_ttc_s: float  # least time to collision with the one ahead and the one behind [s]
    accelerations_mps2: np.ndarray  # (T,) acceleration at each time [m/s^2]


def cost(outcome: LaneOutcome) -> float:
    """Return the cost, from 0 for the best to 1 for what must not be."""
    a = outcome.accelerations_mps2
    keeps_distance = outcome.least_ttc_s >= LEAST_TTC_S
    # TODO 7: 1 minus the score: 0, or the weighted mean (until then: return 0.0)
    if outcome.collides or outcome.breaks_rule:
        return 1.0
    comfortable = bool(np.all((a >= HARDEST_MPS2) & (a <= STRONGEST_MPS2)))
    wanted = PROGRESS * outcome.progress + DISTANCE * keeps_distance + COMFORT * comfortable
    return 1.0 - wanted / (PROGRESS + DISTANCE + COMFORT)
    # ----------------------------------------------------------------------------
