"""Messages of pictures, wheels and traffic lights: their values, and what is refused."""

import math
from types import SimpleNamespace as Message

import numpy as np
import pytest
from cv_bridge import CvBridge, CvBridgeError
from geometry_msgs.msg import Quaternion
from hypothesis import given, settings
from hypothesis import strategies as st
from sensor_msgs.msg import Image

from sdc_common.geometry.route import Route
from sdc_common.planning.stop_line import StopLine
from sdc_common.ros.conversion import check_image, rear_axle_speed, stop_lines

STRAIGHT = Route(np.column_stack([np.arange(201.0), np.zeros(201)]))
BRIDGE = CvBridge()
KNOWN = "bgra8 bgr8 rgb8 rgba8 mono8 mono16 8UC1 8UC4 32FC1 yuv422 bayer_rggb8"
ENCODINGS = st.sampled_from([*KNOWN.split(), "", "nonsense", "8UC", "-1UC3"])
GOOD = {"height": 48, "width": 64, "encoding": "bgra8", "step": 256, "data": bytes(48 * 256)}


def test_good_images_are_accepted():
    check_image(Image(**GOOD))
    check_image(Image(height=1, width=1, encoding="bgr8", step=8, data=bytes(8)))
    check_image(Image(height=1, width=1, encoding="mono8", step=1, data=bytes(1)))


@pytest.mark.parametrize(
    "changes", [{"height": 480}, {"width": 0}, {"data": b""}, {"step": 7}, {"height": 0}]
)
def test_wrong_size_is_an_error(changes):
    with pytest.raises(ValueError, match="do not match"):
        check_image(Image(**{**GOOD, **changes}))


def test_big_endian_picture_is_an_error_that_names_the_fix():
    with pytest.raises(ValueError, match="is_bigendian false"):
        check_image(Image(**GOOD, is_bigendian=True))


@pytest.mark.slow(3)
@settings(max_examples=max(200, settings.default.max_examples))
@given(
    st.integers(0, 40) | st.just(2**31),
    st.integers(0, 40) | st.just(2**31),
    st.integers(0, 200),
    ENCODINGS,
    st.binary(max_size=2000),
    st.booleans(),
)
def test_fuzz_any_image_is_pixels_or_an_error_that_the_camera_handles(
    height, width, step, encoding, data, big_endian
):
    message = Image(
        height=height, width=width, step=step, encoding=encoding, data=data, is_bigendian=big_endian
    )
    try:
        check_image(message)
        pixels = BRIDGE.imgmsg_to_cv2(message, "bgra8")
    except (CvBridgeError, TypeError, ValueError):
        return
    assert pixels.dtype == np.uint8
    assert pixels.shape == (height, width, 4)


def test_speed_is_the_mean_of_the_rear_wheels():
    names = ["front_left_wheel", "rear_left_wheel", "rear_right_wheel"]
    assert rear_axle_speed(names, [99.0, 10.0, 12.0], 0.35) == pytest.approx(3.85)


@pytest.mark.parametrize("rates", [[1.0, math.nan], [1.0, math.inf]])
def test_bad_wheel_speed_is_refused(rates):
    with pytest.raises(ValueError, match="not finite"):
        rear_axle_speed(["rear_left_wheel", "rear_right_wheel"], rates, 0.35)


def test_missing_wheel_is_refused():
    with pytest.raises(ValueError, match="rear_right_wheel"):
        rear_axle_speed(["rear_left_wheel"], [1.0], 0.35)


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
