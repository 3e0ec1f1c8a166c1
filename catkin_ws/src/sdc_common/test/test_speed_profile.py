import math
from types import SimpleNamespace

import numpy as np
import pytest

from sdc_common.configuration import node_config
from sdc_common.planning.speed_profile import SpeedLimits, limited_speeds

LIMITS = {"cruise_mps": 10.0, "lateral_mps2": 4.0, "acceleration_mps2": 1.8, "braking_mps2": 2.5}
STEP_M = 0.5


def limited(path, limits):
    return limited_speeds(path.s, path.curvature, limits)


def path(length_m, curvature=0.0, step_m=STEP_M):
    """Return a path; `curvature` is a number or a function of the arc length."""
    s = np.arange(0.0, length_m + 0.5 * step_m, step_m)
    values = curvature(s) if callable(curvature) else np.full(len(s), curvature)
    return SimpleNamespace(s=s, curvature=values)


def bend_between(start_m, end_m, curvature):
    return lambda s: np.where((s >= start_m) & (s <= end_m), curvature, 0.0)


def in_order(reasons):
    """Return the reasons without those that repeat the one before them."""
    return [one for i, one in enumerate(reasons) if i == 0 or one != reasons[i - 1]]


def test_profile_of_a_straight_is_a_trapezium_with_its_reasons():
    straight = path(200.0)
    speeds, reasons = limited(straight, SpeedLimits(**LIMITS))
    accelerated = np.sqrt(0.5**2 + 2.0 * 1.8 * straight.s)
    braked = np.sqrt(2.0 * 2.5 * (200.0 - straight.s))
    np.testing.assert_allclose(speeds, np.minimum(10.0, np.minimum(accelerated, braked)))
    # At 98 % of the speed that a point allows, the point itself is the reason.
    slow = np.where(straight.s < 100.0, "accelerating", "end_of_route")
    assert reasons == np.where(speeds > 9.8, "cruise", slow).tolist()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_car_brakes_before_a_bend_and_accelerates_after_it(sign):
    around = path(300.0, bend_between(140.0, 160.0, sign * 0.16))
    speeds, reasons = limited(around, SpeedLimits(**LIMITS))
    bend = (around.s >= 140.0) & (around.s <= 160.0)
    np.testing.assert_allclose(speeds[bend], 5.0)
    before, after = 140.0 - around.s, around.s - 160.0
    slowing = (before > 0.0) & (before < 15.0)
    # The last step before the bend ends where no friction is left for braking.
    np.testing.assert_allclose(
        speeds[slowing], np.sqrt(25.0 + 2.0 * 2.5 * (before[slowing] - STEP_M))
    )
    hurrying = (after > 0.0) & (after < 20.0)
    np.testing.assert_allclose(
        speeds[hurrying], np.sqrt(25.0 + 2.0 * 1.8 * (after[hurrying] - STEP_M))
    )
    assert in_order(reasons) == [
        "accelerating",
        "cruise",
        "braking_ahead",
        "bend",
        "accelerating",
        "cruise",
        "end_of_route",
    ]
    assert {reasons[i] for i in np.flatnonzero(bend)} == {"bend"}
    assert set(reasons) < set(node_config("sdc_sim", "report_page")["speed_reasons"])


@pytest.mark.parametrize("step_m", [0.5, 2.0])
def test_braking_and_acceleration_in_a_bend_are_what_the_friction_ellipse_leaves(step_m):
    curvature = 0.05
    speeds, _ = limited(path(200.0, curvature, step_m), SpeedLimits(**LIMITS))
    top_mps = math.sqrt(4.0 / curvature)
    assert speeds.max() == pytest.approx(top_mps)
    along = np.diff(speeds**2) / (2.0 * step_m)
    for used, longitudinal, slow in (
        (speeds[:-1] ** 2 * curvature / 4.0, along / 1.8, slice(0, int(15.0 / step_m))),
        (speeds[1:] ** 2 * curvature / 4.0, along / -2.5, slice(-int(10.0 / step_m), None)),
    ):
        assert (longitudinal[slow] > 0.0).all()
        np.testing.assert_allclose(np.hypot(used, longitudinal)[slow], 1.0)


def test_yaw_rate_limits_the_speed_in_the_tightest_bends():
    around = path(60.0, bend_between(20.0, 40.0, 1.0 / 3.0))
    speeds, reasons = limited(around, SpeedLimits(**LIMITS, yaw_rate_radps=0.8))
    assert (speeds * around.curvature).max() == pytest.approx(0.8)
    assert "bend" in reasons


@pytest.mark.parametrize("step_m", [0.5, 2.0])
@pytest.mark.parametrize("rate", [0.001, -0.004])
def test_lateral_jerk_limits_the_speed_where_the_curvature_changes(rate, step_m):
    clothoid = path(200.0, lambda s: rate * (s - 100.0), step_m)
    limits = SpeedLimits(
        **{**LIMITS, "cruise_mps": 30.0, "lateral_mps2": 1e6}, lateral_jerk_mps3=2.0
    )
    speeds, reasons = limited(clothoid, limits)
    middle = np.abs(clothoid.s - 100.0) < 30.0
    np.testing.assert_allclose(speeds[middle], (2.0 / abs(rate)) ** (1.0 / 3.0))
    assert in_order(reasons) == ["accelerating", "bend", "end_of_route"]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("cruise_mps", math.inf),
        ("lateral_mps2", -1.0),
        ("acceleration_mps2", math.nan),
        ("braking_mps2", 0.0),
        ("lateral_jerk_mps3", 0.0),
        ("yaw_rate_radps", math.nan),
        ("start_mps", 0.0),
    ],
)
def test_limit_that_is_not_positive_is_named(name, value):
    with pytest.raises(ValueError, match=name):
        SpeedLimits(**{**LIMITS, name: value})
