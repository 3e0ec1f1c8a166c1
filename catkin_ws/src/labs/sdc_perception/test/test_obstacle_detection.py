"""Cars, pedestrians and boxes in rendered pictures."""

import math

import pytest

from sdc_common.configuration import node_config
from sdc_perception.obstacle_detection import BodyFinder, ObstacleSettings
from sdc_perception.obstacle_tracker import ObstacleTracker
from sdc_sim.camera.camera_model import CameraModel

CAMERA_X_M = 0.7
INTRINSIC = CameraModel().intrinsic_matrix()
pytestmark = pytest.mark.slow(3)


@pytest.fixture
def settings():
    return ObstacleSettings.read(node_config("sdc_perception", "obstacle_detector").__getitem__)


@pytest.fixture
def finder(settings):
    return BodyFinder(settings, INTRINSIC)


@pytest.mark.parametrize("brightness", [1.0, 0.25])
@pytest.mark.parametrize("ahead_m", [6.0, 15.0, 29.0])
@pytest.mark.parametrize("kind", ["car", "pedestrian", "obstacle"])
def test_kind_and_distance_of_a_body(finder, render, body, kind, ahead_m, brightness):
    found = finder.find(render(body(kind, ahead_m, 1.0), brightness=brightness))
    assert [one.kind for one in found] == [kind]
    assert found[0].x_m - CAMERA_X_M == pytest.approx(ahead_m, rel=0.06)
    assert found[0].y_m == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize(("yaw_rad", "width_m", "depth_m"), [(0.0, 2.0, 4.7), (1.57, 4.7, 2.0)])
def test_car_is_seen_from_behind_or_from_its_side(finder, render, body, yaw_rad, width_m, depth_m):
    (car,) = finder.find(render(body("car", 15.0, 0.0, yaw_rad)))
    assert car.width_m == pytest.approx(width_m, abs=0.3)
    assert car.depth_m == depth_m


def test_two_cars_that_overlap_in_the_picture_are_two(finder, render, body):
    found = finder.find(render(body("car", 12.0), body("car", 26.0, 2.2, math.pi)))
    assert [one.x_m - CAMERA_X_M for one in found] == pytest.approx([12.0, 26.0], rel=0.06)


def test_car_behind_a_pole_is_one(finder, render, body, light):
    (car,) = finder.find(render(body("car", 26.0, 0.0, 1.57), light(2, 12.0, 0.3)))
    assert car.x_m - CAMERA_X_M == pytest.approx(26.0, rel=0.06)
    assert car.width_m == pytest.approx(4.7, abs=0.4)
    assert car.y_m == pytest.approx(0.0, abs=0.2)


@pytest.mark.parametrize("brightness", [1.0, 0.25])
def test_empty_road_has_no_body(finder, render, brightness):
    assert finder.find(render(brightness=brightness)) == []


@pytest.mark.parametrize(
    ("kind", "yaw_rad", "speed_mps"), [("car", 0.0, 4.0), ("pedestrian", 1.5708, 1.4)]
)
def test_speed_and_heading_of_a_body_that_moves(settings, render, body, kind, yaw_rad, speed_mps):
    tracker = ObstacleTracker(settings, INTRINSIC)
    for number in range(30):
        time_s = 0.05 * number
        way_m = speed_mps * time_s
        there = body(kind, 10.0 + way_m * math.cos(yaw_rad), way_m * math.sin(yaw_rad), yaw_rad)
        found = tracker.detect(render(there), (0.0, 0.0, 0.0), time_s)
    (one,) = found
    assert one.speed_mps == pytest.approx(speed_mps, abs=0.5)
    assert one.yaw_rad == pytest.approx(yaw_rad, abs=0.25)
    assert (one.x_m, one.y_m) == pytest.approx((there.x_m, there.y_m), abs=0.7)


def test_body_that_stands_has_no_speed_while_the_car_moves(settings, render, body):
    tracker = ObstacleTracker(settings, INTRINSIC)
    for number in range(20):
        pose = (0.4 * number, 0.0, 0.0)
        found = tracker.detect(render(body("car", 25.0), pose=pose), pose, 0.05 * number)
    assert [one.speed_mps for one in found] == [0.0]
    assert found[0].x_m == pytest.approx(25.0 + CAMERA_X_M + 2.35, abs=0.6)
