"""A drive whose GNSS positions arrive late: how far off is the filter?

python3 -m sdc_localization.late_drive [SEED ...] compares three ways to use such positions.
"""

from __future__ import annotations

import math
import sys
from functools import partial
from typing import Any, Callable

import numpy as np

from sdc_localization.late_gnss import LateLocalizer, use_at_once
from sdc_localization.localizer import Localizer, LocalizerSettings

DELAY_S = 0.3
_STEP_S = 0.05
_TICKS = 1200  # length of the drive
_GNSS_EVERY = 4  # ticks from one position to the next
_FIRST_TICK = 200  # errors count from this tick on
_BIAS_RADPS, _SCALE, _NOISE_M = 0.002, 0.005, 1.0
SETTINGS = LocalizerSettings(
    rear_axle_m=0.0,
    rear_slip_s2pm=0.0,
    initial_across_m=0.2,
    initial_yaw_rad=0.05,
    initial_bias_radps=0.002,
    initial_scale=0.005,
    along_m_per_sqrt_m=0.003,
    across_m_per_sqrt_m=0.003,
    yaw_rad_per_sqrt_s=0.0005,
    yaw_rad_per_sqrt_rad=0.001,
    bias_radps_per_sqrt_s=0.00003,
    scale_per_sqrt_s=0.00001,
    gate_2=13.8,
    reset_after_s=10.0,
)


def late_rms_m(add: Callable, localizer: Localizer, seed: int, delay_s: float = DELAY_S) -> float:
    """Return the RMS of the position error of a drive of a minute after its first 10 s [m].

    Args:
        add: called with the time of the measurement [s], x [m], y [m] and variance [m^2]
        localizer: has not started
        seed: of the drive and the errors of its sensors
        delay_s: how long after its measurement a position arrives; a multiple of 0.05
    """
    random = np.random.default_rng(seed)
    speeds = 9.0 + 3.0 * np.sin(0.05 * np.arange(_TICKS) + random.uniform(0.0, 6.0))
    turns = np.repeat(random.uniform(-0.5, 0.5, _TICKS // 40), 40)
    place, yaw, waiting, squares = 0j, 0.0, [], []
    for tick in range(_TICKS):
        time_s, speed, rate = tick * _STEP_S, float(speeds[tick]), float(turns[tick])
        if tick == 1:
            lane_m = np.array([[-5.0, 0.0], [50.0, 0.0]])
            localizer.start(place.real, place.imag, _NOISE_M**2, lane_m)
        localizer.move(time_s, speed * (1.0 - _SCALE), rate + _BIAS_RADPS)
        if tick:
            # The mean of two readings, as in the filter: there is no other error of the motion.
            speed, rate = 0.5 * (speed + speeds[tick - 1]), 0.5 * (rate + turns[tick - 1])
            place += speed * _STEP_S * np.exp(1j * (yaw + 0.5 * rate * _STEP_S))
            yaw += rate * _STEP_S
        if tick % _GNSS_EVERY == 0 and tick:
            fix = place + complex(*random.normal(0.0, _NOISE_M, 2))
            waiting.append((time_s, fix.real, fix.imag, _NOISE_M**2))
        if waiting and waiting[0][0] + delay_s < time_s + 1e-6:
            add(*waiting.pop(0))
        if tick >= _FIRST_TICK:
            estimate = localizer.estimate
            squares.append(abs(place - complex(estimate.x_m, estimate.y_m)) ** 2)
    return math.sqrt(np.mean(squares))


def after(localizer: Any, arrivals: dict, speed_mps: float = 10.0) -> tuple[list, np.ndarray]:
    """Drive straight along the x axis for 2 s, with some positions.

    Args:
        localizer: has add_late_position, and has not started
        arrivals: by the tick of an arrival, (delay in ticks, error in x [m], error in y [m])
        speed_mps: the speed

    Returns:
        for each position, whether it was used, and how it changed the place (2,) [m]; the state in
        the end
    """
    answers = []
    for tick in range(41):
        localizer.move(tick * _STEP_S, speed_mps, 0.0)
        if tick == 0:
            localizer.start(0.0, 0.0, _NOISE_M**2, np.array([[-5.0, 0.0], [90.0, 0.0]]))
        if tick in arrivals:
            delay, x, y = arrivals[tick]
            measured_s = (tick - delay) * _STEP_S
            before = localizer.state[:2]
            used = localizer.add_late_position(measured_s, speed_mps * measured_s + x, y, 1.0)
            answers.append((bool(used), localizer.state[:2] - before))
    return answers, localizer.state


def ways(seed: int) -> dict[str, float]:
    """Return the errors of filters whose positions are in time, late, and late but in yours [m]."""
    in_time, at_once, late = Localizer(SETTINGS), Localizer(SETTINGS), LateLocalizer(SETTINGS)
    return {
        "in time": late_rms_m(partial(use_at_once, in_time), in_time, seed, 0.0),
        "late, used at once": late_rms_m(partial(use_at_once, at_once), at_once, seed),
        "late, your filter": late_rms_m(late.add_late_position, late, seed),
    }


def main() -> None:
    """Print a line for each seed."""
    for seed in map(int, sys.argv[1:] or ("1", "2", "3")):
        print(f"drive {seed}: " + ", ".join(f"{k} {v:.2f} m" for k, v in ways(seed).items()))


if __name__ == "__main__":
    main()
