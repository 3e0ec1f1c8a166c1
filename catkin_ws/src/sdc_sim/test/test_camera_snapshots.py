import io

import numpy as np
import pytest
from PIL import Image as Picture
from sensor_msgs.msg import Image

from sdc_sim.report.camera_snapshots import jpeg_of

ORANGE = (240, 150, 20)


def image(encoding, pixel, width=640, height=480, step=None):
    row = np.tile(np.array(pixel, np.uint8), width)
    rows = np.zeros((height, step or len(row)), np.uint8)
    rows[:, : len(row)] = row
    return Image(
        height=height, width=width, encoding=encoding, step=rows.shape[1], data=rows.tobytes()
    )


@pytest.mark.parametrize(
    ("encoding", "pixel"),
    [
        ("rgb8", ORANGE),
        ("bgr8", ORANGE[::-1]),
        ("bgra8", (*ORANGE[::-1], 255)),
        ("rgba8", (*ORANGE, 255)),
    ],
)
def test_colours_and_size(encoding, pixel):
    jpeg = jpeg_of(image(encoding, pixel))
    picture = np.asarray(Picture.open(io.BytesIO(jpeg)))
    assert picture.shape == (360, 480, 3)
    assert np.abs(picture[100, 100].astype(int) - ORANGE).max() < 6
    assert len(jpeg) < 50_000


def test_rows_with_a_rim():
    assert jpeg_of(image("rgb8", ORANGE, step=2048)) == jpeg_of(image("rgb8", ORANGE))


def test_what_is_no_picture():
    assert jpeg_of(image("32FC1", (0, 0, 0, 0))) is None
    assert jpeg_of(Image()) is None
    torn = image("rgb8", ORANGE)
    torn.data = torn.data[:-1]
    assert jpeg_of(torn) is None
    wide = image("rgb8", ORANGE)
    wide.width = 10_000
    assert jpeg_of(wide) is None
