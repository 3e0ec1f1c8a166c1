"""The experiments of the lab: what does politeness cost, and what if everyone brakes late?

python3 -m sdc_behaviour.study.experiments politeness|late
"""

from __future__ import annotations

import sys
from typing import Iterator

import numpy as np

from sdc_behaviour.drives import drive_scene
from sdc_behaviour.rss import Rss, safe_distance_m

SEEDS = range(100, 112)
SPEED_MPS = 14.0
CAR_M = 4.7  # length of a car
CARS = 10
_STEP_S = 0.01


def polite(share: float) -> tuple[float, float]:
    """Return mean speed, and greatest braking of one behind, with a share of the safe distance."""
    drives = [drive_scene("lorry", seed, politeness=share) for seed in SEEDS]
    speeds = [drive.mean_mps for drive in drives]
    return float(np.mean(speeds)), max(drive.pushed_mps2 for drive in drives)


def crashes(late_s: float, rss: Rss) -> int:
    """Return how many cars of a column hit the one ahead after the first one brakes to a stop.

    Each keeps the safe distance, and begins to brake `late_s` after the one ahead has begun.
    """
    time_s = np.arange(0.0, 30.0, _STEP_S)
    gap_m = safe_distance_m(SPEED_MPS, SPEED_MPS, rss)
    way_m = _braking_way(time_s, 0.0, rss.other_braking_mps2)
    number = 0
    for car in range(1, CARS):
        behind_m = _braking_way(time_s, car * late_s, rss.own_braking_mps2)
        number += bool(np.any(gap_m + way_m - behind_m < 0.0))
        way_m = behind_m
    return number


def _braking_way(time_s: np.ndarray, begin_s: float, braking_mps2: float) -> np.ndarray:
    """Return the way of a car that brakes to a stop from a time on [m]."""
    braking_s = np.clip(time_s - begin_s, 0.0, SPEED_MPS / braking_mps2)
    driving_m = SPEED_MPS * (np.minimum(time_s, begin_s) + braking_s)
    return driving_m - 0.5 * braking_mps2 * braking_s**2


def flow_per_h(speed_mps: float, rss: Rss) -> float:
    """Return how many cars an hour pass, each at the safe distance [1/h]."""
    return 3600.0 * speed_mps / (safe_distance_m(speed_mps, speed_mps, rss) + 2.0 + CAR_M)


def lines(name: str) -> Iterator[str]:
    """Yield the lines of the table of an experiment."""
    if name == "politeness":
        for share in (0.0, 1.0, 1.5, 4.0):
            mean_mps, hardest = polite(share)
            braking = f"others brake {hardest:.1f} m/s2"
            yield f"politeness {share:.1f}: mean {mean_mps:.2f} m/s, {braking}"
        return
    for late_s in (0.3, 0.5, 1.0):
        number = f"{crashes(late_s, Rss())} of {CARS - 1}"
        yield f"late by {late_s:.1f} s: {number} cars hit the one ahead"
    for response_s in (0.3, 0.5, 1.0):
        flow = flow_per_h(SPEED_MPS, Rss(response_s=response_s))
        yield f"distance for {response_s:.1f} s: {flow:.0f} cars an hour"


def main() -> None:
    """Print the table."""
    name = sys.argv[1] if len(sys.argv) > 1 else ""
    if name not in ("politeness", "late"):
        sys.exit("experiments: name one, politeness or late")
    for line in lines(name):
        print(line, flush=True)


if __name__ == "__main__":
    main()
