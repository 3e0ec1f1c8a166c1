"""The car drives by the picture along a route that was not used to tune it, and in bad weather."""

import cv2
import numpy as np
import pytest

from sdc_perception.study.drives import WEATHERS, drive, drive_nodes
from sdc_perception.study.frames import FrameScore, measure
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.random_routes import random_route
from sdc_sim.road.road import Road
from sdc_sim.scenario.drive_setup import drive_setup
from sdc_sim.simulation.weather import Weather

HELD_OUT = "1019"


@pytest.fixture(autouse=True)
def one_core():
    cv2.setNumThreads(1)


@pytest.mark.nightly
def test_route_that_the_car_does_not_know_is_completed():
    metrics, _, problems, _ = drive(HELD_OUT)
    assert (metrics["status"], problems) == ("completed", [])
    assert metrics["cross_track_rms_m"] <= 0.15
    assert metrics["cross_track_max_m"] <= 0.5


@pytest.mark.slow(10)
def test_nodes_of_the_lab_drive_a_straight_road_by_its_lane():
    route_m = np.column_stack([np.arange(0.0, 41.0, 2.0), np.zeros(21)])
    metrics, *_ = drive_nodes("", route_m, perception="lane", camera="true")
    assert (metrics["status"], metrics["missed_ticks"]) == ("completed", 0)
    assert metrics["cross_track_max_m"] < 0.2


@pytest.mark.nightly
@pytest.mark.parametrize("weather", ["day", "dusk"])
@pytest.mark.parametrize(
    "scenario", ["crossing_pedestrian", "traffic_lights", "stopped_car", "slow_leader"]
)
def test_scenario_is_driven_on_detections(scenario, weather):
    if (scenario, weather) == ("traffic_lights", "dusk"):
        pytest.xfail("at dusk the car stops 0.5 m too early for a light")
    driven = drive(scenario, weather)
    if any("missed_ticks" in problem for problem in driven.problems):
        driven = drive(scenario, weather)  # a busy machine lost an answer of the nodes
    assert driven.problems == []
    assert np.percentile(np.abs(driven.offset_errors_m), 95) < 0.05


@pytest.mark.slow(3)
@pytest.mark.parametrize(
    ("seed", "weather", "off_m"),
    # At the crossing of route 1009 no line is near the car: most of what could be one is rain.
    [(3, "low_sun", 0.08), (1009, "rain", 0.15)],
)
def test_lane_is_found_before_the_car_starts(detector, seed, weather, off_m):
    route, parameters = random_route(seed)[0], WEATHERS[weather]
    state = drive_setup("", route).simulation().snapshot.state
    pose = state.x_m, state.y_m, state.yaw_rad
    renderer = Renderer(Road(route), weather=Weather(**parameters["weather"]))
    for tick in range(9):
        light = parameters.get("daylight", 1.0)
        picture = renderer.render(*pose, light=light, time_s=0.05 * tick)
        lane = detector.detect(picture, pose)
    assert lane.offset_m == pytest.approx(0.0, abs=off_m)
    assert lane.heading_error_rad == pytest.approx(0.0, abs=0.05)


@pytest.mark.slow(4)
@pytest.mark.parametrize("weather", ["day", pytest.param("dusk", marks=pytest.mark.nightly)])
def test_lights_and_bodies_of_random_pictures_are_right(weather):
    score = measure(weather, 40, 2901)
    assert len(score.light_errors) >= 15
    assert score.right_frames >= 39
    assert len(score.body_errors) >= 20
    found = [error for error in score.body_errors if np.isfinite(error)]
    assert len(found) >= 0.97 * len(score.body_errors)
    assert sum(abs(error) < 0.1 for error in found) >= 0.97 * len(found)
    assert score.false_bodies <= 1


def test_table_has_the_sum_of_both_weathers():
    bodies = [0.0, 0.0, 0.2, np.nan]
    day = FrameScore(2, 2, [0.01, 0.02, 0.03], 0, bodies, 1, [(1e-3, 2e-3)] * 2)
    dusk = FrameScore(2, 1, [np.nan], 1, [], 0, [(3e-3, 2e-3)] * 2)
    assert (day + dusk).row("all") == (
        "| all | 4 | 75.00 % | 3 of 4, 1 | 2.0 %, 2.9 % | 3 of 4, 1 | 0.0 %, 18.0 % | 66.67 % "
        "| 2.0 + 2.0 ms |"
    )
