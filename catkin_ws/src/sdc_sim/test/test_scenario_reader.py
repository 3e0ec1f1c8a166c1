"""Tests of the scenario reader: valid files, and the one-line error of each mistake."""

import math
import os
from functools import partial

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sdc_common.geometry.route import Route
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_common.validation import DocumentError
from sdc_sim.physics.obstacles import Obstacles
from sdc_sim.physics.traffic_lights import TrafficLightPlan, light_states
from sdc_sim.scenario.packaged import find_route
from sdc_sim.scenario.reader import load_scenario
from sdc_sim.scenario.traffic import load_traffic
from sdc_testing.street_maps import needs_maps, town

HERE = os.path.dirname(os.path.abspath(__file__))
EXAMPLES = os.path.join(HERE, "..", "config", "obstacles")
with open(os.path.join(HERE, "data", "scenario_mistakes.yaml"), encoding="utf-8") as file:
    MISTAKES = yaml.safe_load(file)
# East for 100 m, then north.
ROUTE = Route(np.vstack([[(x, 0.0) for x in range(101)], [(100.0, y) for y in range(1, 101)]]))


def write(tmp_path, text):
    path = tmp_path / "scenario.yaml"
    path.write_text(text)
    return str(path)


@pytest.mark.parametrize(
    ("at", "x", "y", "yaw"),
    [
        ("[50, 2], yaw_rad: 0.5", 50, 2, 0.5),
        ("[150, 2]", 98, 50, math.pi / 2),
        ("[150, -3]", 103, 50, math.pi / 2),
    ],
)
def test_points_in_route_frame_are_distances_along_and_left_of_the_route(tmp_path, at, x, y, yaw):
    path = write(tmp_path, f"frame: route\nobstacles: [{{kind: obstacle, at: {at}}}]")
    (plan,), _ = load_traffic(path, ROUTE)
    assert plan.points_m[0] == pytest.approx((x, y), abs=1e-6)
    assert plan.yaw_rad == pytest.approx(yaw, abs=1e-6)


def test_packaged_obstacle_files_are_valid():
    route = Route(load_waypoints(find_route("", "town")))
    names = os.listdir(EXAMPLES)
    assert names
    for name in names:
        obstacles, _ = load_traffic(os.path.join(EXAMPLES, name), route)
        assert obstacles


WHOLE = """
about: a bit of everything
route:
  - straight_m: 50
  - {right_deg: 90, radius_m: 12, transition_m: 6}
vehicle: bmw_320i
camera: true
sync: false
seed: 7
friction: 0.6
odometry_noise: {position_m: 0.05}
start: {left_m: 2, turned_rad: -1.0}
frame: route
obstacles: []
lights:
  - stop_line_m: 30
    phases: [red: 5, green: 10.5]
    offset_s: 2
limits:
  status: collision
  at_most: {cross_track_max_m: 0.5, infractions: 1}
  at_least: {red_light: 1}
  stops: [{at_m: 27, within_m: 1}]
"""


def test_all_keys_of_a_scenario_are_read(tmp_path):
    path = write(tmp_path, WHOLE)
    scenario = load_scenario(path)
    assert (scenario.path, scenario.about) == (path, "a bit of everything")
    assert scenario.vehicle == "bmw_320i"
    assert (scenario.camera, scenario.sync) == (True, False)
    bend = {"right_deg": 90.0, "radius_m": 12.0, "transition_m": 6.0}
    assert scenario.route == [{"straight_m": 50.0}, bend]
    start = {"left_m": 2.0, "turned_rad": -1.0}
    noise = {"position_m": 0.05}
    assert scenario.sim == {"seed": 7, "friction": 0.6, "odometry_noise": noise, "start": start}
    assert isinstance(scenario.sim["seed"], int)
    limits = {"at_most": {"cross_track_max_m": 0.5, "infractions": 1.0}, "status": "collision"}
    limits.update(at_least={"red_light": 1.0}, stops=[{"at_m": 27, "within_m": 1}])
    assert scenario.limits == limits
    light = TrafficLightPlan(30.0, 0.0, 0.0, (("red", 5.0), ("green", 10.5)), 2.0)
    assert load_traffic(path, ROUTE) == ([], [light])


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake["message"])
def test_error_names_line_and_fix_of_each_mistake(tmp_path, mistake):
    path = write(tmp_path, mistake["text"])
    read = load_scenario if mistake["read"] == "scenario" else partial(load_traffic, route=ROUTE)
    with pytest.raises(DocumentError) as refusal:
        read(path)
    error = str(refusal.value)
    assert "\n" not in error
    assert error.startswith(path)
    assert mistake["message"] in error
    if mistake["line"]:
        assert f", line {mistake['line']}: " in error


TRAFFIC = """
frame: route
obstacles:
  - {kind: car, at: [30, 2], yaw_rad: 0.5}
  - kind: pedestrian
    path: [[0, 1], [2, 3]]
    speed_mps: 1.4
    trigger_m: 12
    size_m: [0.6, 0.7, 1.8]
lights: [{stop_line_m: 50, phases: [red: 8.0, green: 2]}]
"""


def test_points_in_map_frame_are_map_coordinates(tmp_path):
    path = write(tmp_path, TRAFFIC.replace("route", "map"))
    (parked, walker), _ = load_traffic(path, ROUTE)
    assert (parked.points_m, parked.yaw_rad, parked.size_m) == (((30, 2),), 0.5, (4.7, 2.0, 1.45))
    assert (walker.points_m, walker.size_m) == (((0.0, 1.0), (2.0, 3.0)), (0.6, 0.7, 1.8))
    assert (walker.speed_mps, walker.trigger_m) == (1.4, 12.0)


# Pieces of a scenario that are replaced by others, of wrong types, keys, nesting and tags.
PIECES = st.sampled_from(
    [*"abr019[]{}:,-&*!#.\n", "- ", ".nan", "1e999", "null", "route", "map", "kind: car"]
    + ["&a", "*a", "!!python/object/apply:os.getpid []", "!radians 1", "obstacles:", "lights: [7]"]
)


@st.composite
def contents(draw):
    """Return a scenario in which up to four places are replaced, or any bytes."""
    text = draw(st.sampled_from([WHOLE, TRAFFIC]))
    for _ in range(draw(st.integers(0, 4))):
        start = draw(st.integers(0, len(text)))
        length = draw(st.integers(0, 12))
        text = text[:start] + draw(PIECES | st.text(max_size=4)) + text[start + length :]
    return draw(st.just(text.encode("utf-8", "surrogatepass")) | st.binary(max_size=80))


@pytest.mark.slow(3)
@settings(
    max_examples=max(200, settings.default.max_examples), suppress_health_check=list(HealthCheck)
)
@given(contents())
def test_any_file_is_a_valid_scenario_or_refused_in_one_line(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "fuzz.yaml"
    path.write_bytes(content)
    try:
        scenario = load_scenario(str(path))
        plans, lights = load_traffic(str(path), ROUTE)
    except DocumentError as refusal:
        assert str(refusal).startswith(str(path))
        assert "\n" not in str(refusal)
    else:
        assert scenario.path == str(path)
        for obstacle in Obstacles(plans).states:
            assert all(map(math.isfinite, obstacle[2:]))
        for light in light_states(lights, 12.3):
            assert all(map(math.isfinite, light[1:4]))


@needs_maps
def test_obstacle_on_a_lane_drives_straight_on_and_names_what_is_wrong(tmp_path):
    street = town(tmp_path)

    def load(entry, map_path=street):
        path = tmp_path / "scenario.yaml"
        path.write_text(f"frame: map\nobstacles:\n  - {{kind: van, {entry}}}\n")
        return load_traffic(str(path), ROUTE, map_path)[0][0]

    moving = load("lane: a_1, at_m: 100, speed_mps: 6, trigger_m: 30")
    assert moving.points_m[0] == pytest.approx((-50.0, -4.8))
    # Over both junctions to the end of the street in the east.
    assert max(x for x, _ in moving.points_m) == pytest.approx(260.0)
    assert all(abs(y) < 6.0 for _, y in moving.points_m)
    standing = load("lane: a_1, at_m: 100")
    assert standing.points_m == (moving.points_m[0],) and standing.yaw_rad == pytest.approx(0.0)
    for entry, where, text in (
        ("lane: a_9, at_m: 1", street, "a_9 is no lane of the map"),
        ("lane: a_1, at_m: 999", street, "the lane ends at 142.8 m"),
        ("lane: a_1, at_m: 1", "", "add 'map'"),
        ("lane: a_1", street, "at_m"),
        ("at: [1, 1], speed_mps: 3", street, "without 'speed_mps' at 'at'"),
    ):
        with pytest.raises(DocumentError, match=text):
            load(entry, where)
