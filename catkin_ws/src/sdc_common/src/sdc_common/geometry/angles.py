"""Directions in the plane."""

from __future__ import annotations

import math


def wrap_angle(angle_rad: float) -> float:
    """Return the same direction in [-pi, pi) [rad]."""
    return (angle_rad + math.pi) % (2.0 * math.pi) - math.pi
