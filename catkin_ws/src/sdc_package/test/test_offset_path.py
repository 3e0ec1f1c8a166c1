"""The way of the car beside its route."""

import numpy as np
import pytest
from street_drives import SETTINGS

from sdc_common.geometry.route import Route
from sdc_package.behaviour.offset_path import OffsetPath

MPS = 12.0


def followed(path, s_m):
    """Return slope and second derivative of the line at an arc length."""
    step = np.array([-1.0, 0.0, 1.0])
    before, now, after = np.interp(s_m + step, np.arange(len(path)), path)
    return 0.5 * (after - before), after - 2.0 * now + before


@pytest.mark.parametrize("given_up_m", [30.0, 40.0, 50.0])
def test_shift_that_is_given_up_has_no_kink(given_up_m):
    route = Route(np.column_stack([np.arange(200.0), np.zeros(200)]))
    path = OffsetPath(route, MPS, SETTINGS)
    path.follow(path.shifted(path.offset_m, 3.5, 20.0, MPS), 20.0)
    out = path.offset_m
    path.follow(path.shifted(out, 0.0, given_up_m, MPS), given_up_m)
    slopes = [followed(line, given_up_m)[0] for line in (out, path.offset_m)]
    assert slopes[0] > 0.02 and slopes[1] == pytest.approx(slopes[0], rel=0.1)
    assert path.offset_m[-1] == pytest.approx(0.0, abs=1e-6)
    bends = np.gradient(np.gradient(path.offset_m))
    assert MPS**2 * np.abs(bends).max() < 2.0 * SETTINGS.proposals.shift_mps2


def test_shift_in_a_bend_is_as_slow_as_both_ask_for():
    radius_m, angles = 60.0, np.arange(200.0) / 60.0
    route = Route(radius_m * np.column_stack([np.sin(angles), 1.0 - np.cos(angles)]))
    path = OffsetPath(route, MPS, SETTINGS)
    offset_m = path.shifted(path.offset_m, -3.5, 60.0, MPS)
    bends = np.gradient(np.gradient(offset_m, route.s), route.s)
    most_mps = path.bend_mps(bends, route.curvature, route.s)
    shifting = (route.s > 62.0) & (route.s < 98.0)
    lateral_mps2 = (most_mps**2 * np.abs(bends + 1.0 / radius_m))[shifting]
    assert lateral_mps2.max() < 2.01 * SETTINGS.proposals.shift_mps2
