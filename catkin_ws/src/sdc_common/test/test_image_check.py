import numpy as np
import pytest
from cv_bridge import CvBridge, CvBridgeError
from hypothesis import given, settings
from hypothesis import strategies as st
from sensor_msgs.msg import Image

from sdc_common.ros.conversion import check_image

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
