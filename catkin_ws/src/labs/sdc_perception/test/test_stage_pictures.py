"""The pictures of the stages show what is on the road."""

import math

import numpy as np
import pytest

from sdc_perception.overlay import LINES_BGR
from sdc_perception.stage_pictures import STAGES
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.road import Road

pytestmark = pytest.mark.slow(2)

POSE = (20.0, 0.3, 0.0)
LEFT_M = POSE[1]  # of the car, from the centre of the lane
EDGE_M, DASHES_M = -1.75 - LEFT_M, 1.75 - LEFT_M


@pytest.fixture(scope="module")
def picture():
    road = Road(np.column_stack([np.arange(100.0), np.zeros(100)]))
    return Renderer(road).render(*POSE)


def colours_at(picture, x_m, y_m):
    """Return the colours next to the pixel of a ground point."""
    pixel, _ = CameraModel().project(np.array([[x_m, y_m, 0.0]]), 0.0, 0.0, 0.0)
    column, row = (int(math.floor(value)) for value in pixel[0])
    return picture[row - 1 : row + 3, column - 1 : column + 3, :3].reshape(-1, 3).tolist()


def test_ground_has_a_line_every_metre_to_the_side_and_every_5_m_ahead(detector):
    blank = np.zeros((480, 640, 4), np.uint8)
    STAGES["ground"](blank, detector, POSE)
    for point in ((10.0, 0.5), (7.3, 2.0), (15.0, -1.5)):
        assert np.max(colours_at(blank, *point)) > 150, point
    for point in ((7.3, 0.5), (6.0, 1.5)):
        assert np.max(colours_at(blank, *point)) == 0, point


def test_guess_has_three_lines_of_three_colours(detector, picture):
    drawn = picture.copy()
    STAGES["guess"](drawn, detector, POSE)
    for y, colour in ((EDGE_M, LINES_BGR[0]), (DASHES_M, LINES_BGR[1])):
        assert list(colour) in colours_at(drawn, 8.0, y)
    assert detector.guess(picture).offset_m == pytest.approx(LEFT_M, abs=0.05)
