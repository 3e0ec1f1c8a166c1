"""The lane in rendered pictures."""

import math

import cv2
import numpy as np
import pytest

from sdc_common.configuration import node_config, package_folder
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds
from sdc_perception.lane_detection import DetectorSettings, LaneDetector
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.road import Road
from sdc_sim.road.route_generator import generate_route
from sdc_sim.simulation.weather import Weather

pytestmark = pytest.mark.slow(11)

BENDS = [
    {"straight_m": 25.0},
    {"left_deg": 60.0, "radius_m": 15.0, "transition_m": 4.0},
    {"right_deg": 60.0, "radius_m": 10.0, "transition_m": 4.0},
    {"straight_m": 15.0},
]
SPEC = {"elements": BENDS, "start": {"x_m": 0.0, "y_m": 0.0, "heading_deg": 0.0}, "spacing_m": 1.0}


@pytest.fixture(scope="module")
def road():
    return Road(generate_route(SPEC)[:, :2] * [1.0, -1.0])


@pytest.fixture(scope="module")
def renderer(road):
    cv2.setNumThreads(1)
    return Renderer(road)


def pose_at(road, s_m, left_m=0.0, turned_rad=0.0):
    points, left = road.at(np.array([s_m]))
    x, y = points[0] + left_m * left[0]
    return float(x), float(y), math.atan2(-left[0, 0], left[0, 1]) + turned_rad


@pytest.mark.parametrize(
    ("left_m", "turned_rad"), [(0.0, 0.0), (0.6, 0.0), (-0.5, 0.1), (0.2, -0.15)]
)
def test_lane_is_found_in_a_single_picture(road, renderer, detector, left_m, turned_rad):
    pose = pose_at(road, 0.0, left_m, turned_rad)
    lane = detector.detect(renderer.render(*pose), pose)
    assert lane.offset_m == pytest.approx(left_m, abs=0.08)
    assert lane.heading_error_rad == pytest.approx(-turned_rad, abs=0.02)
    assert lane.confidence > 0.8


def test_lane_filter_takes_no_windows_and_trunks_for_markings():
    camera = CameraModel()
    thresholds = LaneFilterThresholds(**node_config("sdc_package", "camera")["lane_filter"])
    straight = np.column_stack([np.arange(0.0, 200.0), np.zeros(200)])
    town = Renderer(Road(straight), camera, seed=5)
    beside = []
    for x_m in np.arange(0.0, 110.0, 10.0):
        rows, columns = np.nonzero(LaneFilter(thresholds).mask(town.render(x_m, 0.0, 0.0)))
        pixels = np.stack([columns, rows, np.ones(len(rows))])
        rays = camera.map_from_optical(0.0) @ np.linalg.solve(camera.intrinsic_matrix(), pixels)
        # The road is from 1.75 m right of the car to 5.25 m left of it.
        left_m = camera.mount_z_m * rays[1] / -rays[2]
        beside.append(np.mean(np.abs(left_m - 1.75) > 5.0))
    assert np.mean(beside) < 0.022


def test_lane_is_tracked_through_bends(road, renderer, detector):
    """The car weaves; the odometry is exact in a frame of its own."""
    for s in np.arange(0.0, road.length_m - 2.0, 0.7):
        left_m, turned_rad = 0.3 * math.sin(s / 6.0), 0.04 * math.cos(s / 5.0)
        pose = pose_at(road, s, left_m, turned_rad)
        lane = detector.detect(renderer.render(*pose), pose)
        assert lane.offset_m == pytest.approx(left_m, abs=0.1), f"at {s:.1f} m"
        assert lane.heading_error_rad == pytest.approx(-turned_rad, abs=0.05), f"at {s:.1f} m"
        assert lane.confidence > 0.6
    assert lane.visible_m > 10.0


@pytest.mark.parametrize("weather", [{"rain": 1.0}, {"worn_lines": 0.6}], ids=["rain", "worn"])
def test_lane_is_tracked_in_bad_weather(road, detector, weather):
    renderer = Renderer(road, weather=Weather(**weather))
    for s in np.arange(0.0, road.length_m - 2.0, 0.7):
        pose = pose_at(road, s)
        lane = detector.detect(renderer.render(*pose), pose)
        assert lane.offset_m == pytest.approx(0.0, abs=0.15), f"at {s:.1f} m"
        assert lane.confidence > 0.6


@pytest.mark.parametrize(
    ("from_m", "to_m", "weather"),
    [(30.0, 116.0, Weather()), (335.0, 366.0, Weather()), (285.0, 318.0, Weather(worn_lines=0.6))],
    ids=["past the exit", "bend of 4 m radius", "bend with worn lines"],
)
def test_lane_of_the_town_is_tracked(parameters, from_m, to_m, weather):
    """The edge at the exit of the roundabout leads away; in the tight bend, it is out of view."""
    road = Road(load_waypoints(f"{package_folder('sdc_common')}/data/waypoints.csv"))
    directions = node_config("sdc_perception", "town_directions")["directions"]
    renderer = Renderer(road, weather=weather)
    for direction in directions:
        direction.update({name: direction[name] - from_m for name in ("from_m", "to_m")})
    parameters["directions"] = directions
    settings = DetectorSettings.read(parameters.__getitem__)
    detector = LaneDetector(settings, CameraModel().intrinsic_matrix())
    for s in np.arange(from_m, to_m, 0.8):
        pose = pose_at(road, s)
        lane = detector.detect(renderer.render(*pose), pose)
        assert lane.offset_m == pytest.approx(0.0, abs=0.15), f"at {s:.1f} m"
        assert lane.confidence > 0.6


def test_meadow_has_no_lane(renderer, detector):
    pose = (0.0, -60.0, 0.0)
    assert detector.detect(renderer.render(*pose), pose) is None


def test_confidence_falls_without_markings_until_the_lane_is_lost(road, renderer, detector):
    pose = pose_at(road, 0.0)
    picture = renderer.render(*pose)
    detector.detect(picture, pose)
    blank, confidences = np.full_like(picture, 80), []
    for step in range(300):
        lane = detector.detect(blank, (pose[0] + 0.5 * step, pose[1], pose[2]))
        if lane is None:
            break
        confidences.append(lane.confidence)
    assert confidences[0] > 0.8
    assert lane is None
    assert sorted(confidences, reverse=True) == pytest.approx(confidences, abs=0.02)


def test_lane_is_acquired_again_when_the_odometry_starts_again(road, renderer, detector):
    pose = pose_at(road, 0.0)
    picture = renderer.render(*pose)
    detector.detect(picture, pose)
    lane = detector.detect(picture, (500.0, 0.0, 1.0))
    assert lane.offset_m == pytest.approx(0.0, abs=0.08)
