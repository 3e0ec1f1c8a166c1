"""Tests of the places of obstacles and lights in a scenario, and of the messages about them."""

import math
import re

import numpy as np
import pytest

from sdc_common.geometry.route import Route
from sdc_sim.physics.obstacles import ObstaclePlan
from sdc_sim.scenario.reader import load_scenario
from sdc_sim.scenario.traffic import load_lights, load_obstacles
from sdc_sim.yaml_document import DocumentError

# East for 100 m, then north.
ROUTE = Route(np.vstack([[(x, 0.0) for x in range(101)], [(100.0, y) for y in range(1, 101)]]))
CAR = "frame: map\nobstacles:\n  - kind: car\n    "


def write(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    return str(path)


def refused(tmp_path, message):
    return pytest.raises(
        DocumentError, match=f"^{re.escape(str(tmp_path / 'mine.yaml') + message)}$"
    )


def test_yaw_is_added_to_the_heading_of_the_route(tmp_path):
    text = "frame: route\nobstacles: [{kind: car, at: [150, 0], yaw_rad: 0.5}]"
    (plan,) = load_obstacles(write(tmp_path, text), ROUTE)
    assert plan.yaw_rad == pytest.approx(0.5 * math.pi + 0.5)


def test_path_in_the_route_frame_has_no_yaw_and_its_own_timing(tmp_path):
    text = (
        "frame: route\nobstacles:\n"
        "  - {kind: pedestrian, path: [[10, 2], [20, -2]], speed_mps: 1.5, start_s: 3}\n"
    )
    (plan,) = load_obstacles(write(tmp_path, text), ROUTE)
    assert (plan.kind, plan.points_m) == ("pedestrian", ((10.0, 2.0), (20.0, -2.0)))
    assert (plan.speed_mps, plan.start_s) == (1.5, 3.0)
    default = ObstaclePlan("pedestrian", ((0.0, 0.0),), plan.size_m)
    assert (plan.trigger_m, plan.yaw_rad) == (default.trigger_m, default.yaw_rad)


@pytest.mark.parametrize("along_m", [0, 200])
def test_light_may_be_at_either_end_of_the_route(tmp_path, along_m):
    text = f"lights:\n  - {{stop_line_m: {along_m}, phases: [red: 1]}}"
    (plan,) = load_lights(write(tmp_path, text), ROUTE)
    assert (plan.x_m, plan.y_m) == ((0.0, 0.0) if along_m == 0 else (100.0, 100.0))
    assert plan.offset_s == 0.0


@pytest.mark.parametrize(
    ("place", "line"),
    [("at: [200.5, 0]", 4), ("path: [[1, 0],\n  [200.5, 0]]\n    speed_mps: 1", 5)],
)
def test_place_beyond_the_route_is_refused_with_its_line(tmp_path, place, line):
    text = CAR.replace("map", "route") + place
    with refused(
        tmp_path,
        f", line {line}: the place is 200.5 m along a route of 200.0 m; "
        "give a distance from 0 to 200.0",
    ):
        load_obstacles(write(tmp_path, text), ROUTE)


def test_scenario_without_obstacles_and_lights_has_none(tmp_path):
    path = write(tmp_path, "seed: 7.0")
    assert (load_obstacles(path, ROUTE), load_lights(path, ROUTE)) == ([], [])
    assert load_lights("", ROUTE) == []
    seed = load_scenario(path).sim["seed"]
    assert (seed, type(seed)) == (7, int)


def test_changed_file_is_read_again(tmp_path):
    path = write(tmp_path, "about: first")
    assert load_scenario(path).about == "first"
    write(tmp_path, "about: another")
    assert load_scenario(path).about == "another"
