"""What every steering method does."""

import importlib.util
import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from planned_roads import path_of

from sdc_common.configuration import node_config
from sdc_package.steering.axles import Axles
from sdc_package.steering.loader import METHODS, load_steering
from sdc_package.steering.method import predicted_pose

pytestmark = pytest.mark.slow(8)
# The lab that has this method, and the solver that it needs, may not be installed.
HAS_MPC = importlib.util.find_spec("sdc_mpc") and importlib.util.find_spec("osqp")
METHODS = [method for method in METHODS if method != "mpc" or HAS_MPC]

CONFIG = node_config("sdc_package", "simple_controller")
# With stiff tyres the car of these tests rolls without slip.
STIFF = Axles(1.435, 1.435, 1e-5, 1e-5)
# Some releases of hypothesis count their own retries as examples that are too large.
QUIET = settings(deadline=None, suppress_health_check=[HealthCheck.data_too_large])
BUILT = {name: load_steering(name, CONFIG[name], STIFF) for name in METHODS}


def build(method, axles=STIFF, **changes):
    """Return a method with the parameters of the configuration, a new one if it keeps a state."""
    if method not in ("kinematic", "mpc") and axles is STIFF and not changes:
        return BUILT[method]
    return load_steering(method, {**CONFIG[method], **changes}, axles)


def bend(curvature, count=30):
    """Return points 1 m apart along an arc, which begins 8 m behind the origin."""
    return [
        (
            math.sin(s * curvature) / curvature if curvature else float(s),
            (1.0 - math.cos(s * curvature)) / curvature if curvature else 0.0,
        )
        for s in range(-8, count - 8)
    ]


@pytest.mark.parametrize("method", METHODS)
def test_car_without_an_error_on_a_straight_line_does_not_steer(method):
    assert build(method).wheel_angle(path_of(bend(0.0)), 0.3, 0.0, 0.0, 5.0) == pytest.approx(
        0.0, abs=1e-12
    )


@pytest.mark.parametrize("method", [name for name in METHODS if "preview_s" in CONFIG[name]])
def test_pose_is_predicted_over_the_preview(method):
    pose, speed, rate = (2.0, 0.7, 0.2), 5.0, 0.5
    later = predicted_pose(*pose, speed, rate, 0.3)
    now, ahead = (build(method, preview_s=preview_s) for preview_s in (0.0, 0.3))
    wheel = ahead.wheel_angle(path_of(bend(0.05)), *pose, speed, rate)
    assert wheel == now.wheel_angle(path_of(bend(0.05)), *later, speed, rate)
    other = build(method, preview_s=0.0).wheel_angle(path_of(bend(0.05)), *pose, speed, rate)
    assert wheel != other


@pytest.mark.parametrize("method", METHODS)
def test_each_parameter_out_of_range_is_refused_by_its_name(method):
    for name in CONFIG[method]:
        with pytest.raises(ValueError, match=f"{name}.* got -1.0"):
            build(method, **{name: -1.0})


poses = st.tuples(
    st.floats(-0.1, 0.1),
    st.floats(-1.0, 1.0),
    st.floats(-2.0, 2.0),
    st.floats(-0.6, 0.6),
    st.floats(0.0, 25.0),
    st.floats(-0.5, 0.5),
)


@pytest.mark.parametrize("method", METHODS)
@settings(QUIET, max_examples=40)
@given(pose=poses)
def test_left_is_the_mirror_image_of_right(method, pose):
    curvature, x, y, yaw, speed, rate = pose
    left = build(method).wheel_angle(path_of(bend(curvature)), x, y, yaw, speed, rate)
    mirror = [(px, -py) for px, py in bend(curvature)]
    right = build(method).wheel_angle(path_of(mirror), x, -y, -yaw, speed, -rate)
    assert right == pytest.approx(-left, abs=1e-9)
    assert math.isfinite(left)


@pytest.mark.parametrize("method", METHODS)
@settings(QUIET, max_examples=40)
@given(
    pose=poses,
    turn=st.floats(-3.0, 3.0),
    shift=st.tuples(st.floats(-500.0, 500.0), st.floats(-500.0, 500.0)),
)
def test_place_and_direction_on_the_map_do_not_matter(method, pose, turn, shift):
    curvature, x, y, yaw, speed, rate = pose

    def moved(px, py):
        return (
            shift[0] + px * math.cos(turn) - py * math.sin(turn),
            shift[1] + px * math.sin(turn) + py * math.cos(turn),
        )

    here = build(method).wheel_angle(path_of(bend(curvature)), x, y, yaw, speed, rate)
    there = build(method).wheel_angle(
        path_of([moved(*point) for point in bend(curvature)]), *moved(x, y), yaw + turn, speed, rate
    )
    # Inside of a corner two segments may be equally near, so that rounding decides.
    assert there == pytest.approx(here, abs=0.02)


# The textbook law and LQR without feed-forward leave an error in a bend.
@pytest.mark.parametrize("method", [name for name in METHODS if name not in ("stanley", "lqr")])
@pytest.mark.parametrize("radius", [6.0, 12.0, 60.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_car_on_a_circle_keeps_the_wheel_angle_of_the_bicycle(method, radius, side):
    """With its centre on the circle, the heading of the car differs by the slip angle."""
    slip = math.asin(STIFF.rear_m / radius)
    speed = 4.0
    # Points every 0.25 m, so that the corners between them do not matter.
    points = [
        (radius * math.sin(s / radius), side * radius * (1.0 - math.cos(s / radius)))
        for s in [0.25 * i - 8.0 for i in range(130)]
    ]
    now = {"preview_s": 0.0} if "preview_s" in CONFIG[method] else {}
    wheel = build(method, **now).wheel_angle(
        path_of(points), 0.0, 0.0, -side * slip, speed, side * speed / radius
    )
    assert wheel == pytest.approx(side * math.atan(2.0 * math.tan(slip)), abs=0.02)
