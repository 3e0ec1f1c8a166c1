"""Geometry of the clothoid spline."""

import math

import numpy as np
import pytest

from sdc_perception.lane_curve import LaneCurve

BENDS = 0.05 * np.sin(np.arange(9.0))


def test_jacobian_is_that_of_finite_differences():
    curve = LaneCurve(1.0, 2.0, 0.5, BENDS)
    jacobian, step = curve.jacobian(), 1e-6
    for k in range(jacobian.shape[1]):
        change = np.zeros(jacobian.shape[1])
        change[k] = step
        moved = curve.moved(change).points_m - curve.points_m
        assert np.sum(moved * curve.left, axis=1) / step == pytest.approx(
            jacobian[:, k], abs=2e-3, rel=2e-3
        )


@pytest.mark.parametrize("offset", [-1.5, 0.0, 2.0])
def test_nearest_place_is_found_on_both_sides_of_a_bend(offset):
    curve = LaneCurve(0.0, 0.0, 0.0, np.full(9, 0.1))
    for s in (3.1, 7.4, 12.25):
        radius = 10.0 - offset
        place = curve.nearest(radius * math.sin(0.1 * s), 10.0 - radius * math.cos(0.1 * s))
        assert place.s_m == pytest.approx(s, abs=0.02)
        assert place.offset_m == pytest.approx(offset, abs=0.01)
        assert place.heading_rad == pytest.approx(0.1 * s, abs=0.005)
