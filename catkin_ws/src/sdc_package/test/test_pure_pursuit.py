import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from planned_roads import path_of

from sdc_common.geometry.polyline import Polyline
from sdc_package.steering.axles import Axles
from sdc_package.steering.pure_pursuit import (
    PurePursuitSteering,
    look_ahead_point,
    pure_pursuit_angle,
)

AXLES = Axles(front_m=1.2, rear_m=1.6, front_compliance=0.008, rear_compliance=0.006)
PARAMETERS = {
    "look_ahead_s": 0.8,
    "shortest_look_ahead_m": 3.0,
    "longest_look_ahead_m": 12.0,
    "preview_s": 0.0,
}
LINE = Polyline([(float(x), 0.0) for x in range(10)] + [(9.0, float(y)) for y in range(1, 10)])


@given(st.floats(5.0, 100.0), st.floats(0.1, 1.5))
def test_arc_ends_at_the_look_ahead_point(radius, alpha):
    """The chord of a circle at the angle alpha has the length 2 R sin(alpha)."""
    assert pure_pursuit_angle(alpha, 2.0 * radius * math.sin(alpha), 2.5) == pytest.approx(
        math.atan(2.5 / radius)
    )


@pytest.mark.parametrize(
    ("x", "y", "distance", "goal"),
    [
        (0.5, 0.0, 3.0, (3.5, 0.0)),
        (0.0, 3.0, 5.0, (4.0, 0.0)),
        (8.0, 0.0, 3.0, (9.0, math.sqrt(8.0))),
        (9.0, 8.0, 5.0, (9.0, 13.0)),
        (0.0, -3.0, 2.0, (2.0, 0.0)),
        (0.0, -4.75, 5.0, (5.0, 0.0)),
        (0.0, -1.8, 2.0, (math.sqrt(0.76), 0.0)),
        (9.0, 11.0, 5.0, (9.0, 16.0)),
    ],
)
def test_look_ahead_point_in_every_place_of_the_line(x, y, distance, goal):
    """On the line, next to it, around the corner, beyond the end, and too far from the line."""
    assert look_ahead_point(LINE, x, y, distance) == pytest.approx(goal)


def steering(axles=AXLES, **changes):
    return PurePursuitSteering(axles, **{**PARAMETERS, **changes})


@pytest.mark.parametrize(
    ("speed", "look_ahead"), [(0.0, 3.0), (3.0, 3.0), (5.0, 4.0), (10.0, 8.0), (30.0, 12.0)]
)
@pytest.mark.parametrize("error", [0.0, 0.3])
def test_look_ahead_distance_grows_with_the_speed_between_its_limits(speed, look_ahead, error):
    """The rear axle is 1 m left of a straight line with the heading 0.6."""
    path = path_of([(i * math.cos(0.6), i * math.sin(0.6)) for i in range(-20, 60)])
    yaw = 0.6 + error
    x = -math.sin(0.6) + 1.6 * math.cos(yaw)
    y = math.cos(0.6) + 1.6 * math.sin(yaw)
    alpha = -math.asin(1.0 / look_ahead) - error
    assert steering().wheel_angle(path, x, y, yaw, speed) == pytest.approx(
        math.atan(2.0 * 2.8 * math.sin(alpha) / look_ahead)
    )


def test_limits_of_the_look_ahead_distance_must_be_in_order():
    steering(shortest_look_ahead_m=5.0, longest_look_ahead_m=5.0)
    with pytest.raises(
        ValueError, match="^shortest_look_ahead_m 5 exceeds longest_look_ahead_m 4.5$"
    ):
        steering(shortest_look_ahead_m=5.0, longest_look_ahead_m=4.5)
