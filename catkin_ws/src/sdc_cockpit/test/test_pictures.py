"""Rate limit and encoding of pictures."""

import cv2
import numpy as np
import pytest
from sensor_msgs.msg import Image

from sdc_cockpit.pictures import DriveSpeed, RateLimit, jpeg_file, mask_png


def image(pixels, encoding):
    rows, columns = pixels.shape[:2]
    step = pixels.nbytes // rows
    return Image(height=rows, width=columns, encoding=encoding, step=step, data=pixels.tobytes())


@pytest.mark.parametrize(("every_s", "expected"), [(0.002, 20), (0.05, 20), (0.1, 10)])
def test_rate_is_limited(every_s, expected):
    limit = RateLimit(20.0)
    admitted = sum(limit.admits(100.0 + n * every_s) for n in range(round(10.0 / every_s)))
    assert admitted / 10.0 == pytest.approx(expected, rel=0.02)


def test_uneven_pictures_of_the_right_rate_all_pass():
    limit = RateLimit(20.0)
    times = [100.0 + 0.05 * n + (0.015 if n % 2 else 0.0) for n in range(100)]
    assert all(map(limit.admits, times))


@pytest.mark.parametrize(("speed", "is_lockstep"), [(0.9, False), (1.1, False), (4.0, True)])
def test_lockstep_is_faster_than_real_time(speed, is_lockstep):
    measured = DriveSpeed()
    for now_s in np.arange(100.0, 103.0, 0.05 / speed):
        measured.add(now_s, 50.0 + speed * now_s)
    assert measured.is_lockstep == is_lockstep


def test_colours_of_the_camera_arrive():
    pixels = np.zeros((48, 64, 4), np.uint8)
    pixels[:, :, :3] = (200, 90, 10)
    file = jpeg_file(image(pixels, "bgra8"), 90)
    decoded = cv2.imdecode(np.frombuffer(file, np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(decoded[24, 32].astype(int) - (200, 90, 10)).max() < 8


def test_mask_arrives_exactly():
    pixels = np.zeros((48, 64), np.uint8)
    pixels[10:20, 30:40] = 255
    file = mask_png(image(pixels, "mono8"))
    decoded = cv2.imdecode(np.frombuffer(file, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert (decoded == pixels).all()


def test_damaged_picture_is_refused():
    message = image(np.zeros((48, 64, 4), np.uint8), "bgra8")
    message.data = message.data[:100]
    with pytest.raises(ValueError, match="do not match"):
        jpeg_file(message, 90)
    with pytest.raises(ValueError):
        jpeg_file(image(np.zeros((48, 64, 4), np.uint8), "nonsense"), 90)
