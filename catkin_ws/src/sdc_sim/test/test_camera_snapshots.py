import base64
import io

import numpy as np
import pytest
import rospy
from PIL import Image as Picture
from sensor_msgs.msg import Image

from sdc_sim.report.camera_snapshots import CameraSnapshots, encode_jpeg

ORANGE = (240, 150, 20)


def image(encoding, pixel, width=640, height=480, step=None):
    row = np.tile(np.array(pixel, np.uint8), width)
    rows = np.zeros((height, step or len(row)), np.uint8)
    rows[:, : len(row)] = row
    size = {"height": height, "width": width, "step": rows.shape[1]}
    return Image(encoding=encoding, data=rows.tobytes(), **size)


@pytest.mark.parametrize(
    ("encoding", "pixel"),
    [("rgb8", ORANGE), ("bgr8", ORANGE[::-1]), ("bgra8", (*ORANGE[::-1], 255))]
    + [("rgba8", (*ORANGE, 255))],
)
def test_jpeg_has_the_colours_of_the_image_and_a_small_size(encoding, pixel):
    jpeg = base64.b64decode(encode_jpeg(image(encoding, pixel), 480, 80))
    picture = np.asarray(Picture.open(io.BytesIO(jpeg)))
    assert picture.shape == (360, 480, 3)
    assert np.abs(picture[100, 100].astype(int) - ORANGE).max() < 6
    assert len(jpeg) < 50_000


def test_unsupported_images_give_no_jpeg():
    assert encode_jpeg(image("32FC1", (0, 0, 0, 0)), 480, 80) is None
    assert encode_jpeg(Image(), 480, 80) is None


class Camera:
    """Takes the place of rospy.Subscriber; `send` delivers a picture to a subscription."""

    def __init__(self, monkeypatch, count):
        self.subscribed = None
        self.subscriptions = 0
        self.snapshots, self.pictures = [], []
        monkeypatch.setattr(rospy, "Subscriber", self.subscribe)
        self.taken = CameraSnapshots(["/image"], count, self.add)

    def add(self, name, *arguments):
        if name == "snapshot":
            self.snapshots.append(arguments)
        else:
            assert (name, arguments[0]) == ("scene", "picture")
            self.pictures.append(arguments[1:])

    @staticmethod
    def size_of(jpeg):
        return Picture.open(io.BytesIO(base64.b64decode(jpeg))).size

    def subscribe(self, topic, message_class, callback, **options):
        self.subscribed = callback
        self.subscriptions += 1
        return self

    def unregister(self):
        self.subscribed = None

    def update(self, percent, now_s, wall_s):
        self.taken.update(percent, now_s, wall_s)
        if self.subscribed:
            message = image("rgb8", ORANGE)
            message.header.stamp = rospy.Time.from_sec(now_s)
            self.subscribed(message)
        self.taken.update(percent, now_s, wall_s)


def test_pictures_are_taken_over_the_time_and_snapshots_over_the_distance(monkeypatch):
    camera = Camera(monkeypatch, 2)
    for tick in range(801):
        camera.update(tick / 8.0, 0.05 * tick, 0.05 * tick)
    assert [round(time_s, 2) for time_s, _ in camera.pictures[:3]] == [0.0, 1.5, 3.0]
    assert [percent for _, percent, _ in camera.snapshots] == [25.0, 75.0]
    assert camera.subscriptions == len(camera.pictures) == 28, "a snapshot is a picture as well"
    sizes = [camera.size_of(jpeg) for _, _, jpeg in camera.snapshots]
    assert sizes == [(480, 360)] * 2
    assert camera.size_of(camera.pictures[0][1]) == (320, 240)


def test_fast_drive_takes_at_most_two_pictures_per_second_of_the_wall_clock(monkeypatch):
    camera = Camera(monkeypatch, 1)
    for tick in range(1000):
        camera.update(0.0, 1.0 * tick, 0.01 * tick)
    assert len(camera.pictures) == 20
