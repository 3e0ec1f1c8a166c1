"""The car drives by the lane in the picture, along a route that was not used to tune it."""

import cv2
import numpy as np
import pytest

from sdc_experiments.perception import WEATHERS, LaneDriver, drive_by_lane, route_named
from sdc_sim.camera.renderer import Renderer
from sdc_sim.evaluation.route_progress import COMPLETED
from sdc_sim.road.road import Road
from sdc_sim.scenario.drive_setup import drive_setup
from sdc_sim.simulation.weather import Weather

pytestmark = pytest.mark.slow(10)
HELD_OUT = "1019"


@pytest.fixture(autouse=True)
def one_core():
    cv2.setNumThreads(1)


def test_route_that_the_car_does_not_know_is_completed():
    drive = drive_by_lane(route_named(HELD_OUT)[0])
    metrics = drive.result.metrics
    assert metrics["status"] == COMPLETED
    assert metrics["cross_track_rms_m"] <= 0.15
    assert metrics["cross_track_max_m"] <= 0.5
    assert np.percentile(np.abs(drive.offset_errors_m), 95) <= 0.10


def test_lane_is_found_in_the_deep_shadow_of_a_low_sun():
    route = route_named("3")[0]
    weather = Weather.read(WEATHERS["low_sun"]["weather"])
    observation = drive_setup("", route).simulation().observation
    pose = observation.state.x_m, observation.state.y_m, observation.state.yaw_rad
    picture = Renderer(Road(route), weather=weather).render(*pose)
    lane = LaneDriver().detector.detect(picture, pose)
    assert lane.offset_m == pytest.approx(0.0, abs=0.08)


def test_lane_at_a_crossing_is_found_in_rain_before_the_car_starts():
    """No line is near the car: streaks of rain are most of what could be one."""
    route, rain = route_named("1009")[0], WEATHERS["rain"]
    observation = drive_setup("", route).simulation().observation
    pose = observation.state.x_m, observation.state.y_m, observation.state.yaw_rad
    renderer = Renderer(Road(route), weather=Weather.read(rain["weather"]))
    detector = LaneDriver().detector
    for tick in range(9):
        picture = renderer.render(*pose, light=rain["daylight"], time_s=0.05 * tick)
        lane = detector.detect(picture, pose)
    assert lane.offset_m == pytest.approx(0.0, abs=0.15)
    assert lane.heading_error_rad == pytest.approx(0.0, abs=0.05)


def test_car_without_a_lane_stays_where_it_is():
    driver = LaneDriver()
    blank = np.full((480, 640, 4), 80, np.uint8)
    lane = driver.detector.detect(blank, (0.0, 0.0, 0.0))
    rows = driver.path(lane, (0.0, 0.0, 0.0))
    assert [speed for _, _, speed in rows] == [0.0, 0.0]
