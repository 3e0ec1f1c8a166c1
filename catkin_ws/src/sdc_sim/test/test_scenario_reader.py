"""Tests of the scenario reader: valid files, and the one-line error of each mistake."""

from __future__ import annotations

import math
import os

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sdc_common.geometry.route import Route
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.physics.obstacles import Obstacles
from sdc_sim.physics.traffic_lights import TrafficLightPlan, TrafficLights
from sdc_sim.scenario.acceptance_limits import AcceptanceLimits, RequiredStop
from sdc_sim.scenario.reader import load_scenario
from sdc_sim.scenario.traffic import load_lights, load_obstacles
from sdc_sim.yaml_document import DocumentError

HERE = os.path.dirname(os.path.abspath(__file__))
EXAMPLES = os.path.join(HERE, "..", "config", "obstacles")
# East for 100 m, then north.
ROUTE = Route(np.vstack([[(x, 0.0) for x in range(101)], [(100.0, y) for y in range(1, 101)]]))


def load(tmp_path, text):
    path = tmp_path / "scenario.yaml"
    path.write_text(text)
    return load_obstacles(str(path), ROUTE)


def test_points_in_map_frame_are_map_coordinates(tmp_path):
    standing, moving = load(
        tmp_path,
        """
frame: map
obstacles:
  - {kind: car, at: [3, -2.5], yaw_rad: 1.5}
  - kind: pedestrian
    path: [[0, 1], [2, 3]]
    speed_mps: 1.4
    trigger_m: 12
    size_m: [0.6, 0.7, 1.8]
""",
    )
    assert (standing.kind, standing.points_m, standing.yaw_rad, standing.size_m) == (
        "car",
        ((3.0, -2.5),),
        1.5,
        (4.7, 2.0, 1.45),
    )
    assert (moving.points_m, moving.speed_mps, moving.trigger_m) == (
        ((0.0, 1.0), (2.0, 3.0)),
        1.4,
        12.0,
    )
    assert moving.size_m == (0.6, 0.7, 1.8)


@pytest.mark.parametrize(
    ("at", "x", "y", "yaw"),
    [
        ([50, 2], 50, 2, 0.0),
        ([150, 2], 98, 50, math.pi / 2),
        ([150, -3], 103, 50, math.pi / 2),
    ],
)
def test_points_in_route_frame_are_distances_along_and_left_of_the_route(tmp_path, at, x, y, yaw):
    (plan,) = load(tmp_path, f"frame: route\nobstacles: [{{kind: obstacle, at: {at}}}]")
    assert plan.points_m[0] == pytest.approx((x, y), abs=1e-6)
    assert plan.yaw_rad == pytest.approx(yaw, abs=1e-6)


def test_packaged_obstacle_files_are_valid():
    route = Route(
        load_waypoints(os.path.join(HERE, "..", "..", "sdc_common", "data", "waypoints.csv"))
    )
    names = os.listdir(EXAMPLES)
    assert names
    for name in names:
        assert load_obstacles(os.path.join(EXAMPLES, name), route)


ENTRY = "frame: map\nobstacles:\n  - "


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("", None, "empty"),
        ("frame: map\nobstackles: []", 2, "did you mean 'obstacles'"),
        ("frame: map\nobstacles: 7", 2, "must be a list"),
        (ENTRY + "at: [0, 0]", 3, "'kind' is missing"),
        (ENTRY + "kind: car\n    att: [0, 0]", 4, "did you mean 'at'"),
        (ENTRY + "kind: car", 3, "either 'at'"),
        (ENTRY + "{kind: car, at: [0, 0], path: [[0, 0], [1, 1]], speed_mps: 1}", 3, "either 'at'"),
        (ENTRY + "kind: car\n    at: [0, 1e9]", 4, "must be a number from"),
        (ENTRY + "kind: car\n    at: [0]", 4, "list of 2 numbers"),
        (
            ENTRY + "kind: car\n    at: [0, 0]\n    speed_mps: 3",
            5,
            "'path' is missing, 'speed_mps' needs it",
        ),
        (ENTRY + "kind: car\n    path: [[0, 0], [1, 0]]", 4, "'speed_mps' is missing"),
        (
            ENTRY + "kind: car\n    path: [[0, 0], [1, 0]]\n    speed_mps: 1\n    yaw_rad: 1",
            6,
            "'at' is missing, 'yaw_rad' needs it",
        ),
        (ENTRY + "kind: car\n    path: [[0, 0]]\n    speed_mps: 1", 4, "at least 2 points"),
        (ENTRY + "kind: car\n    path: [[0, 0], [0, 0]]\n    speed_mps: 1", 4, "repeats"),
        (
            ENTRY + "{kind: car, path: [[0, 0], [1, 0]], speed_mps: 1, start_s: 1, trigger_m: 1}",
            3,
            "only one of 'start_s' and 'trigger_m'",
        ),
        (
            ENTRY + "kind: car\n    at: [0, 0]\n    size_m: [1, 1, 0]",
            5,
            "entry 3 of 'size_m' must be a number from 0.05 to 50, got 0",
        ),
        ("frame: route\nobstacles:\n  - kind: car\n    at: [5000, 0]", 4, "along a route of"),
    ],
)
def test_error_names_line_and_fix_of_obstacle_mistake(tmp_path, text, line, message):
    with pytest.raises(DocumentError) as refusal:
        load(tmp_path, text)
    error = str(refusal.value)
    assert "\n" not in error
    assert error.startswith(str(tmp_path / "scenario.yaml"))
    assert message in error
    if line:
        assert f", line {line}: " in error


def test_missing_file_and_binary_file_are_refused(tmp_path):
    with pytest.raises(DocumentError, match="nowhere.yaml: .*obstacles_path"):
        load_obstacles("/nowhere.yaml", ROUTE)
    (tmp_path / "picture.png").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(DocumentError, match="not a text file"):
        load_obstacles(str(tmp_path / "picture.png"), ROUTE)


def test_aliases_are_resolved(tmp_path):
    path = write(tmp_path, "limits:\n  at_most: &same {ticks: 3}\n  at_least: *same")
    limits = load_scenario(path).limits
    assert limits.at_most == limits.at_least == {"ticks": 3}


@pytest.mark.parametrize(
    "text",
    [
        "a: &a [0, 0, 0]\n"
        + "".join(f"{b}: &{b} [{f'*{a}, ' * 50}]\n" for a, b in zip("abcde", "bcdef")),
        "seed: !!int seven",
        "about: !!bool maybe",
        "1: 2",
    ],
    ids=["alias bomb", "int tag", "bool tag", "key that is not text"],
)
def test_file_that_has_no_json_equivalent_is_refused(tmp_path, text):
    with pytest.raises(DocumentError, match="not valid YAML"):
        load_scenario(write(tmp_path, text))


def test_unknown_key_is_reported_before_the_key_that_it_replaces(tmp_path):
    with pytest.raises(
        DocumentError, match="line 3: unknown key 'wihtin_m'; did you mean 'within_m'"
    ):
        load_scenario(write(tmp_path, "limits:\n  stops:\n    - {at_m: 5, wihtin_m: 1}"))


def test_first_mistake_in_the_file_is_reported(tmp_path):
    with pytest.raises(DocumentError, match="line 2: 'friction'"):
        load_scenario(write(tmp_path, "about: x\nfriction: 9\nside_wind_mps: 900"))


WHOLE = """
about: a bit of everything
route:
  - straight_m: 50
  - {right_deg: 90, radius_m: 12, transition_m: 6}
vehicle: bmw_320i
stack: student_nodes
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


def write(tmp_path, text):
    path = tmp_path / "scenario.yaml"
    path.write_text(text)
    return str(path)


def test_all_keys_of_a_scenario_are_read(tmp_path):
    path = write(tmp_path, WHOLE)
    scenario = load_scenario(path)
    assert (scenario.name, scenario.about) == ("scenario", "a bit of everything")
    assert (scenario.vehicle, scenario.stack) == ("bmw_320i", "student_nodes")
    assert (scenario.camera, scenario.sync) == (True, False)
    assert scenario.route == [
        {"straight_m": 50.0},
        {"right_deg": 90.0, "radius_m": 12.0, "transition_m": 6.0},
    ]
    assert scenario.sim == {
        "seed": 7,
        "friction": 0.6,
        "odometry_noise": {"position_m": 0.05},
        "start": {"left_m": 2.0, "turned_rad": -1.0},
    }
    assert isinstance(scenario.sim["seed"], int)
    assert scenario.limits == AcceptanceLimits(
        "collision",
        {"cross_track_max_m": 0.5, "infractions": 1.0},
        {"red_light": 1.0},
        (RequiredStop(27.0, 1.0),),
    )
    assert load_obstacles(path, ROUTE) == []
    assert load_lights(path, ROUTE) == [
        TrafficLightPlan(30.0, 0.0, 0.0, (("red", 5.0), ("green", 10.5)), 2.0)
    ]


LIGHT = "lights:\n  - "


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("frictoin: 0.5", 1, "did you mean 'friction'"),
        (
            "about: x\nfriction: slippery",
            2,
            "'friction' must be a number from 0.05 to 2, got 'slippery'",
        ),
        ("seed: 1.5", 1, "whole number"),
        ("start:\n  left_m: far", 2, "'left_m' must be a number from -50 to 50, got 'far'"),
        ("gnss:\n  noise: 1", 2, "did you mean 'noise_m'"),
        ("gnss:\n  outages:\n    - {from_m: 1}", 3, "either from_m and to_m"),
        ("imu:\n  rate_noise_radps: -1", 2, "from 0 to 1000"),
        ("truth: maybe", 1, "'truth' must be true or false"),
        ("about: x\nstack: /tmp/evil", 2, "not a path"),
        ("route: []", 1, "must be a list of elements"),
        ("route:\n  - straight: 50", 2, "did you mean 'straight_m'"),
        ("route:\n  - straight_m: 50\n  - {left_deg: 90, radius_m: 10}", 3, "left_deg"),
        (
            "route:\n  - straight_m: 50\n  - {left_deg: 10, radius_m: 10, transition_m: 9}",
            3,
            "shorten transition_m",
        ),
        ("route:\n  - straight_m: 15000\n  - straight_m: 15000", 3, "longer than"),
        ("limits:\n  at_most:\n    cross_track_maxi_m: 1", 3, "did you mean 'cross_track_max_m'"),
        ("limits:\n  stops:\n    - at_m: 5", 3, "key 'within_m' is missing in entry 1 of 'stops'"),
        (
            "about: !!python/object/apply:os.system ['true']\nfriction: 1",
            1,
            "must be a line of text",
        ),
    ],
)
def test_error_names_line_and_fix_of_scenario_mistake(tmp_path, text, line, message):
    path = write(tmp_path, text)
    with pytest.raises(DocumentError) as refusal:
        load_scenario(path)
    error = str(refusal.value)
    assert "\n" not in error
    assert error.startswith(path)
    assert message in error
    if line:
        assert f", line {line}: " in error


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        (LIGHT + "stop_line_m: 20", 2, "'phases' is missing"),
        (LIGHT + "stop_line_m: 20\n    phases: []", 3, "must be a list of phases"),
        (LIGHT + "stop_line_m: 20\n    phases: [blue: 5]", 3, "unknown key 'blue'"),
        (LIGHT + "stop_line_m: 20\n    phases: [{red: 5, green: 5}]", 3, "one colour"),
        (LIGHT + "stop_line_m: 20\n    phases: [red: 0]", 3, "from 0.05"),
        (LIGHT + "stop_line_m: 5000\n    phases: [red: 5]", 2, "along a route of"),
    ],
)
def test_error_names_line_and_fix_of_light_mistake(tmp_path, text, line, message):
    with pytest.raises(DocumentError) as refusal:
        load_lights(write(tmp_path, text), ROUTE)
    assert f", line {line}: " in str(refusal.value)
    assert message in str(refusal.value)


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
# Pieces of a scenario that are replaced by others, of wrong types, keys, nesting and tags.
PIECES = st.sampled_from(
    [
        *"abr019[]{}:,-&*!#.\n",
        "- ",
        ".nan",
        "1e999",
        "null",
        "route",
        "map",
        "kind: car",
        "&a",
        "*a",
    ]
    + ["!!python/object/apply:os.getpid []", "!radians 1", "obstacles:", "lights: [7]"]
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
    max_examples=max(500, settings.default.max_examples), suppress_health_check=list(HealthCheck)
)
@given(contents())
def test_any_file_is_a_valid_scenario_or_refused_in_one_line(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "fuzz.yaml"
    path.write_bytes(content)
    try:
        scenario = load_scenario(str(path))
        plans, lights = load_obstacles(str(path), ROUTE), load_lights(str(path), ROUTE)
    except DocumentError as refusal:
        assert str(refusal).startswith(str(path))
        assert "\n" not in str(refusal)
    else:
        assert scenario.path == str(path)
        for obstacle in Obstacles(plans).states:
            assert all(map(math.isfinite, obstacle[2:]))
        for light in TrafficLights(lights).states(12.3):
            assert all(map(math.isfinite, light[1:4]))
