import io

import numpy as np
import pytest
from PIL import Image as Picture
from sensor_msgs.msg import Image

from sdc_sim.report.camera_snapshots import encode_jpeg

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
def test_jpeg_has_the_colours_of_the_image_and_a_small_size(encoding, pixel):
    jpeg = encode_jpeg(image(encoding, pixel), 480, 80)
    picture = np.asarray(Picture.open(io.BytesIO(jpeg)))
    assert picture.shape == (360, 480, 3)
    assert np.abs(picture[100, 100].astype(int) - ORANGE).max() < 6
    assert len(jpeg) < 50_000


def test_padding_of_rows_is_removed():
    assert encode_jpeg(image("rgb8", ORANGE, step=2048), 480, 80) == encode_jpeg(
        image("rgb8", ORANGE), 480, 80
    )


def test_unsupported_images_give_no_jpeg():
    assert encode_jpeg(image("32FC1", (0, 0, 0, 0)), 480, 80) is None
    assert encode_jpeg(Image(), 480, 80) is None
    torn = image("rgb8", ORANGE)
    torn.data = torn.data[:-1]
    assert encode_jpeg(torn, 480, 80) is None
    wide = image("rgb8", ORANGE)
    wide.width = 10_000
    assert encode_jpeg(wide, 480, 80) is None
