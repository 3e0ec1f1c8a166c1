"""A camera on a straight road."""

import math

import cv2
import numpy as np
import pytest

from sdc_common.configuration import node_config
from sdc_perception.lane_detection import DetectorSettings, LaneDetector
from sdc_sim.camera.boxes import obstacle_box, traffic_light_box
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.renderer import Renderer
from sdc_sim.physics.obstacles import ObstaclePlan, SimulatedObstacle
from sdc_sim.physics.traffic_lights import FIRST_ID, TrafficLightState
from sdc_sim.road.road import Road


@pytest.fixture
def parameters():
    """Parameters of the lane detector."""
    return node_config("sdc_perception", "lane_detector")


@pytest.fixture
def detector(parameters):
    settings = DetectorSettings.read(parameters.__getitem__)
    return LaneDetector(settings, CameraModel().intrinsic_matrix())


@pytest.fixture(scope="session")
def render():
    """Return a function that renders boxes on a straight road along x from the origin."""
    cv2.setNumThreads(1)
    renderer = Renderer(Road(np.column_stack([np.arange(0.0, 120.0), np.zeros(120)])))

    def picture(*boxes, brightness=1.0, pose=(0.0, 0.0, 0.0)):
        return renderer.render(*pose, boxes, brightness)

    return picture


@pytest.fixture(scope="session")
def light():
    """Return a function that places a light: its pole is at this distance ahead of the camera."""

    def place(state, ahead_m, left_m=-2.7, turned_rad=0.0):
        x_m = ahead_m + CameraModel().mount_x_m
        return traffic_light_box(TrafficLightState(FIRST_ID, x_m, left_m, turned_rad, state))

    return place


@pytest.fixture(scope="session")
def body():
    """Return a function that places a body: its nearest side is that far ahead of the camera."""

    def place(kind, ahead_m, left_m=0.0, yaw_rad=0.0):
        still = SimulatedObstacle(1, ObstaclePlan.stationary(kind, 0.0, left_m, yaw_rad)).body
        c, s = abs(math.cos(yaw_rad)), abs(math.sin(yaw_rad))
        half_m = 0.5 * (still.length_m * c + still.width_m * s)
        return obstacle_box(still._replace(x_m=ahead_m + CameraModel().mount_x_m + half_m))

    return place
