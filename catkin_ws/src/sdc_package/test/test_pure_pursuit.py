import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_common.geometry.polyline import Polyline
from sdc_package.steering.pure_pursuit import look_ahead_point, pure_pursuit_angle

LINE = Polyline([(float(x), 0.0) for x in range(10)] + [(9.0, float(y)) for y in range(1, 10)])


def test_angle_by_hand():
    assert pure_pursuit_angle(math.radians(30.0), 5.0, 2.5) == pytest.approx(math.atan(0.5))
    assert pure_pursuit_angle(0.0, 5.0, 2.5) == 0.0


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
    ],
)
def test_look_ahead_point_in_every_place_of_the_line(x, y, distance, goal):
    """On the line, next to it, around the corner, beyond the end, and too far from the line."""
    assert look_ahead_point(LINE, x, y, distance) == pytest.approx(goal)


@given(st.floats(0.0, 8.0), st.floats(-2.0, 2.0), st.floats(2.5, 12.0))
def test_look_ahead_point_is_ahead_at_the_look_ahead_distance(x, y, distance):
    goal_x, goal_y = look_ahead_point(LINE, x, y, distance)
    assert math.hypot(goal_x - x, goal_y - y) == pytest.approx(distance)
    assert goal_x + goal_y > x - 1e-9


def test_look_ahead_distance_must_be_positive():
    with pytest.raises(ValueError, match="positive"):
        look_ahead_point(LINE, 0.0, 0.0, 0.0)
