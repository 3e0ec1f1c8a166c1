import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from planned_roads import path_of

from sdc_package.steering.axles import Axles
from sdc_package.steering.kinematic import ChainedForm, KinematicSteering

AXLES = Axles(front_m=1.2, rear_m=1.6, front_compliance=0.008, rear_compliance=0.006)
SPEED = 5.0
# 1 / (convergence_m + convergence_s * speed)
K = 0.25
AHEAD = pytest.approx(0.0, abs=1e-12)


def steering(axles=AXLES, preview_s=0.0):
    return KinematicSteering(axles, convergence_m=2.5, convergence_s=0.3, preview_s=preview_s)


# A straight line through the origin with this heading, and a way to name places beside it.
HEADING = 0.6
STRAIGHT = path_of([(i * math.cos(HEADING), i * math.sin(HEADING)) for i in range(-30, 60)])


def beside(along_m, left_m, heading_error=0.0):
    """Return the pose of a car whose rear axle is at this place of the straight line."""
    yaw = HEADING + heading_error
    return (
        along_m * math.cos(HEADING) - left_m * math.sin(HEADING) + 1.6 * math.cos(yaw),
        along_m * math.sin(HEADING) + left_m * math.cos(HEADING) + 1.6 * math.sin(yaw),
        yaw,
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


@pytest.mark.parametrize("left_m", [0.8, -0.5])
@pytest.mark.parametrize("heading_error", [0.0, 0.2, -0.3])
def test_wheels_turn_over_the_distance_that_the_car_drives(left_m, heading_error):
    """dx2/dx1 = -k1 x4 - k2 x3 - k3 x2, where x1 is the distance along the path."""
    car = steering()
    before_m = left_m - 1.5 * math.tan(heading_error)
    assert car.wheel_angle(STRAIGHT, *beside(0.0, before_m, heading_error), SPEED) == AHEAD
    x2, tan, along_m = 0.0, math.tan(heading_error), 1.5 / 10000
    for _ in range(10000):
        x2 += along_m * (-(K**3) * left_m - 3.0 * K * K * tan - 3.0 * K * x2)
    wheel = math.atan(2.8 * math.cos(heading_error) ** 3 * x2)
    assert car.wheel_angle(STRAIGHT, *beside(1.5, left_m, heading_error), SPEED) == pytest.approx(
        wheel, abs=1e-4
    )
