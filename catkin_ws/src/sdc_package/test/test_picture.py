import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sensor_msgs.msg import Image

from sdc_package.picture import bgra_pixels

ENCODINGS = st.sampled_from(["bgra8", "bgr8", "rgb8", "rgba8", "mono8", "mono16", "8UC1", "8UC4", "32FC1", "yuv422", "bayer_rggb8",
                             "", "nonsense", "8UC", "-1UC3"])


def test_pixels_come_as_they_were():
    pixels = np.arange(4 * 3 * 4, dtype=np.uint8).reshape(4, 3, 4)
    message = Image(height=4, width=3, encoding="bgra8", step=12, data=pixels.tobytes())
    np.testing.assert_array_equal(bgra_pixels(message), pixels)
    padded = Image(height=1, width=1, encoding="bgr8", step=8, data=bytes([1, 2, 3, 0, 0, 0, 0, 0]))
    np.testing.assert_array_equal(bgra_pixels(padded), [[[1, 2, 3, 255]]])


@settings(max_examples=max(500, settings.default.max_examples))
@given(st.integers(0, 40) | st.just(2**31), st.integers(0, 40) | st.just(2**31), st.integers(0, 200), ENCODINGS, st.binary(max_size=2000),
       st.booleans())
def test_any_picture_is_pixels_or_a_value_error(height, width, step, encoding, data, big_endian):
    try:
        pixels = bgra_pixels(Image(height=height, width=width, step=step, encoding=encoding, data=data, is_bigendian=big_endian))
    except ValueError as error:
        assert "\n" not in str(error) or "OpenCV" in str(error)
    else:
        assert pixels.dtype == np.uint8
        assert pixels.shape == (height, width, 4)


@pytest.mark.parametrize("changes", [{"height": 480}, {"width": 0}, {"data": b""}, {"step": 7}, {"encoding": "nonsense"}])
def test_a_wrong_size_or_encoding_is_named(changes):
    fields = {"height": 48, "width": 64, "encoding": "bgra8", "step": 256, "data": bytes(48 * 256)}
    with pytest.raises(ValueError, match="x 48|x 480|nonsense|bytes"):
        bgra_pixels(Image(**{**fields, **changes}))
