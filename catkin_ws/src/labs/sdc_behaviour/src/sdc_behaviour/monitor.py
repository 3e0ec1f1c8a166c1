"""A monitor says whether a drive has kept a rule, and by how much: signal temporal logic.

Donze, Maler: Robust Satisfaction of Temporal Logic over Real-Valued Signals, FORMATS 2010. The
robustness of a rule is positive where it is kept, and its size is the margin: "and" is a minimum,
"or" a maximum, "always" a minimum over time, "eventually" a maximum over time.
"""

from __future__ import annotations

import numpy as np


def always(robustness: np.ndarray, ticks: int) -> np.ndarray:
    """Return, at each tick, the robustness of "from now on for so many ticks".

    Args:
        robustness: (T,) robustness of what must hold at each tick
        ticks: length of the window; the present tick and as many after it, as far as there are

    Returns:
        (T,) robustness
    """
    # TODO 9: the least value in the window that begins at each tick (until then: return robustness)
    return np.array([robustness[at : at + ticks + 1].min() for at in range(len(robustness))])
    # ----------------------------------------------------------------------------


def eventually(robustness: np.ndarray, ticks: int) -> np.ndarray:
    """Return, at each tick, the robustness of "at some time in the next ticks"."""
    return -always(-np.asarray(robustness), ticks)


def keeps_distance(gap_m: np.ndarray, speed_mps: np.ndarray, time_s: float = 2.0) -> float:
    """Return the robustness of "the car always keeps so much time to the one ahead" [m].

    Args:
        gap_m: (T,) distance to the one ahead, inf without one [m]
        speed_mps: (T,) speed of the car [m/s]
        time_s: the time [s]
    """
    return float(always(gap_m - time_s * speed_mps, len(gap_m))[0])


def stops_at_line(to_line_m: np.ndarray, speed_mps: np.ndarray, ticks: int) -> np.ndarray:
    """Return, at each tick, the robustness of "the car will stop at the line".

    It stops at the line if, at some tick of the window, its front is before the line, at most 2 m
    from it, and it is slower than 0.3 m/s.

    Args:
        to_line_m: (T,) distance from the front of the car to the line, negative behind it [m]
        speed_mps: (T,) speed of the car [m/s]
        ticks: length of the window
    """
    # TODO 10: an "and" of three, and "eventually" (until then: return to_line_m)
    stops = np.minimum(np.minimum(to_line_m, 2.0 - to_line_m), 0.3 - speed_mps)
    return eventually(stops, ticks)
    # ----------------------------------------------------------------------------
