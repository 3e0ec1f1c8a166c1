"""The projection agrees with the camera of the world, and its inverse with itself."""

import math

import numpy as np
import pytest

from sdc_perception.ground_plane import GroundPlane, MountingPose
from sdc_sim.camera.camera_model import CameraModel

MODEL = CameraModel()
GROUND = GroundPlane(MODEL.intrinsic_matrix(), MountingPose(0.7, 1.7, math.radians(0.5)))


@pytest.mark.parametrize("point", [(5.0, 0.0), (8.0, -1.75), (30.0, 5.25), (3.2, 1.0)])
def test_pixels_are_those_of_the_world(point):
    pixel, _ = MODEL.project(np.array([[*point, 0.0]]), 0.0, 0.0, 0.0)
    assert GROUND.pixels(np.array(point)) == pytest.approx(pixel[0], abs=1e-6)


def test_points_of_pixels_are_the_ground_points():
    points = np.array([(4.0, 1.0), (12.0, -3.0), (40.0, 0.0)])
    assert GROUND.points(GROUND.pixels(points)) == pytest.approx(points)


def test_pixel_above_the_horizon_has_no_ground_point():
    assert np.isnan(GROUND.points(np.array([320.0, 100.0]))).all()


def test_point_behind_the_camera_has_no_pixel():
    assert np.isnan(GROUND.pixels(np.array([-3.0, 0.0]))).all()
