import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_package.steering.kinematic import ChainedForm


def test_wheel_angle_on_the_path_matches_its_curvature():
    assert ChainedForm(2.5).wheel_angle(0.0, 0.0, 0.0, 0.1, 0.0, 0.3) == pytest.approx(
        math.atan(0.25)
    )


def test_wheel_angle_inside_of_a_bend_is_that_of_a_tighter_circle():
    """With x2 = 0, a car parallel to a bend of 10 m radius, 1 m inside, drives a circle of 9 m."""
    assert ChainedForm(2.5).wheel_angle(0.0, 1.0, 0.0, 0.1, 0.0, 0.3) == pytest.approx(
        math.atan(2.5 / 9.0)
    )


@given(
    st.floats(-1.0, 1.0),
    st.floats(-0.4, 0.4),
    st.sampled_from([-0.05, 0.0, 0.02]),
    st.floats(0.15, 0.5),
)
def test_error_follows_its_linear_equation_in_any_bend(cross_track, heading_error, curvature, k):
    """Without slip, the error over the distance is that of (p + k)^3: exact linearization."""
    form, wheelbase, step = ChainedForm(2.5), 2.5, 0.01
    d, theta = cross_track, heading_error
    form.wheel_angle(0.0, d, theta, curvature, 0.0, k)
    x4, x3, x2 = d, (1.0 - d * curvature) * math.tan(theta), 0.0
    for _ in range(1500):
        wheel = form.wheel_angle(step, d, theta, curvature, 0.0, k)
        along = step * math.cos(theta) / (1.0 - d * curvature)
        d += step * math.sin(theta)
        theta += step * math.tan(wheel) / wheelbase - curvature * along
        x4, x3, x2 = (
            x4 + along * x3,
            x3 + along * x2,
            x2 + along * (-(k**3) * x4 - 3.0 * k * k * x3 - 3.0 * k * x2),
        )
    assert d == pytest.approx(x4, abs=0.02)


def test_wheel_angle_far_from_the_path_is_finite():
    form = ChainedForm(2.5)
    for heading_error in (-3.0, 1.6, 3.0):
        for cross_track in (-50.0, 9.9, 10.1, 50.0):
            assert (
                abs(form.wheel_angle(0.5, cross_track, heading_error, 0.1, 0.01, 0.3))
                < 0.5 * math.pi
            )


@pytest.mark.parametrize("heading_error", [0.5, 1.3, 1.6, 2.4, 3.0])
def test_car_turns_back_from_any_heading_error(heading_error):
    assert ChainedForm(2.5).wheel_angle(2.0, 0.0, heading_error, 0.0, 0.0, 0.3) < -0.05
    assert ChainedForm(2.5).wheel_angle(2.0, 0.0, -heading_error, 0.0, 0.0, 0.3) > 0.05
