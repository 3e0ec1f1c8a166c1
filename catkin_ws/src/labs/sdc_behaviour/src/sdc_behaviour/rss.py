"""The safe distance of Responsibility-Sensitive Safety (Shalev-Shwartz, Shammah, Shashua, 2017).

https://arxiv.org/abs/1708.06374, definition 1 and lemma 2. A distance is safe if the car does not
touch the one ahead in the worst case: the one ahead brakes as hard as it can, and the car still
accelerates while it reacts, and then brakes only as hard as it surely can.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

_REST_M = 2.0  # gap to the vehicle ahead at rest
_COMFORTABLE_MPS2 = 2.0  # deceleration with which the car approaches a slower vehicle


@dataclass(frozen=True)
class Rss:
    """What the worst case is."""

    response_s: float = 0.3  # time until the car brakes [s]
    accelerating_mps2: float = 1.8  # its greatest acceleration in this time [m/s^2]
    own_braking_mps2: float = 5.0  # deceleration that it surely reaches [m/s^2]
    other_braking_mps2: float = 7.0  # greatest deceleration of the one ahead [m/s^2]


def safe_distance_m(rear_mps: float, front_mps: float, rss: Rss) -> float:
    """Return the least safe distance from bumper to bumper, at least 0 [m].

    Args:
        rear_mps: speed of the car behind [m/s]
        front_mps: speed of the one ahead [m/s]
        rss: what the worst case is
    """
    rho, accelerating = rss.response_s, rss.accelerating_mps2
    # TODO 6: while it reacts + while it brakes - of the one ahead (until then: return 0.0)
    fastest_mps = rear_mps + rho * accelerating
    reacting_m = rear_mps * rho + 0.5 * accelerating * rho**2
    braking_m = fastest_mps**2 / (2.0 * rss.own_braking_mps2)
    front_m = front_mps**2 / (2.0 * rss.other_braking_mps2)
    return max(reacting_m + braking_m - front_m, 0.0)
    # ----------------------------------------------------------------------------


def following_mps2(
    speed_mps: float, gap_m: float, front_mps: float, wanted_mps: float, rss: Rss
) -> float:
    """Return the acceleration of a car that follows, and keeps the safe distance [m/s^2].

    The Intelligent Driver Model (Treiber, Hennecke, Helbing, 2000), eq. 3; its desired distance is
    at least the safe one.

    Args:
        speed_mps: speed of the car [m/s]
        gap_m: distance to the one ahead, inf without one [m]
        front_mps: its speed [m/s]
        wanted_mps: speed of the car on a free road [m/s]
        rss: what the worst case is
    """
    approach_m = (
        speed_mps
        * (speed_mps - front_mps)
        / (2.0 * math.sqrt(rss.accelerating_mps2 * _COMFORTABLE_MPS2))
    )
    wanted_m = _REST_M + max(safe_distance_m(speed_mps, front_mps, rss), approach_m)
    free = 1.0 - (speed_mps / max(wanted_mps, 0.1)) ** 4
    free = max(free, -_COMFORTABLE_MPS2 / rss.accelerating_mps2)
    taken = 0.0 if math.isinf(gap_m) else (wanted_m / max(gap_m, 0.1)) ** 2
    return max(rss.accelerating_mps2 * (free - taken), -rss.other_braking_mps2)
