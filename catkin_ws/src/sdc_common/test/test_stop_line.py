import math
from types import SimpleNamespace as Message

import numpy as np
import pytest
from geometry_msgs.msg import Quaternion

from sdc_common.geometry.route import Route
from sdc_common.planning.stop_line import StopLine
from sdc_common.ros.conversion import stop_lines

STRAIGHT = Route(np.column_stack([np.arange(201.0), np.zeros(201)]))


def light(number, x, y, yaw, centre, size):
    """Return a traffic light as in a message of the CARLA bridge."""
    orientation = Quaternion(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    return Message(
        id=number,
        transform=Message(position=Message(x=x, y=y, z=5.0), orientation=orientation),
        trigger_volume=Message(
            center=Message(x=centre[0], y=centre[1], z=1.0), size=Message(x=size[0], y=size[1])
        ),
    )


def lines_of(*lights):
    return stop_lines(Message(traffic_lights=lights))


@pytest.mark.parametrize(
    ("yaw", "middle"), [(0.0, (14.0, 18.0)), (0.5 * math.pi, (12.0, 24.0)), (math.pi, (6.0, 22.0))]
)
def test_line_is_in_the_middle_of_the_turned_trigger_volume(yaw, middle):
    line = lines_of(light(7, 10.0, 20.0, yaw, (4.0, -2.0), (1.0, 3.5)))[7]
    assert (line.x_m, line.y_m) == pytest.approx(middle)


@pytest.mark.parametrize("size", [(1.0, 3.5), (3.5, 1.0), (-3.5, 1.0), (1.0, -3.5)])
def test_line_is_as_wide_as_the_longer_side_of_the_trigger_volume(size):
    assert lines_of(light(7, 0.0, 0.0, 0.0, (0.0, 0.0), size))[7].half_width_m == 1.75


def test_each_light_has_its_own_line():
    lights = [light(number, number, 0.0, 0.0, (0.0, 0.0), (1.0, 4.0)) for number in (3, 5)]
    assert lines_of(*lights) == {3: (3.0, 0.0, 2.0, 6.0), 5: (5.0, 0.0, 2.0, 6.0)}
    assert lines_of() == {}


@pytest.mark.parametrize(
    "wrong",
    [
        light(9, math.nan, 0.0, 0.0, (0.0, 0.0), (1.0, 3.5)),
        light(9, 0.0, 0.0, 0.0, (0.0, math.inf), (1.0, 3.5)),
        light(9, 0.0, 0.0, 0.0, (0.0, 0.0), (math.inf, 3.5)),
    ],
)
def test_number_that_is_not_finite_is_refused_with_the_light(wrong):
    with pytest.raises(ValueError, match="^a number of traffic light 9 is not finite$"):
        lines_of(light(7, 0.0, 0.0, 0.0, (0.0, 0.0), (1.0, 3.5)), wrong)


@pytest.mark.parametrize(
    ("x_m", "y_m", "s_m"),
    [
        (100.0, 0.0, 100.0),
        (100.0, 1.75, 100.0),
        (100.0, -1.75, 100.0),
        (100.0, 1.8, None),
        (58.0, 0.0, None),
        (130.0, 0.0, None),
    ],
)
def test_route_crosses_the_lines_in_its_lane_on_the_searched_stretch(x_m, y_m, s_m):
    assert StopLine(x_m, y_m, 1.75).along(STRAIGHT, 60.0, 60.0) == s_m
