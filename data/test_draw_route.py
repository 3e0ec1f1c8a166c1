import math
import os
import sys

import numpy as np
import pytest
import yaml

from sdc_sim.road.route_generator import RouteSpecError, curvature_profile, generate_route
from sdc_testing.program import run

FOLDER = os.path.dirname(os.path.abspath(__file__))
SCRIPT = sys.executable, os.path.join(FOLDER, "draw_route.py")


def spec(*elements, heading_deg=0.0):
    return {
        "spacing_m": 1.0,
        "start": {"x_m": 0.0, "y_m": 0.0, "heading_deg": heading_deg},
        "elements": list(elements),
    }


def test_straight_ends_at_its_length():
    rows = generate_route(spec({"straight_m": 10}, heading_deg=90.0))
    np.testing.assert_allclose(rows[-1], [0.0, -10.0, -90.0], atol=1e-9)
    assert rows.shape == (11, 3)


@pytest.mark.parametrize(("side", "sign"), [("left_deg", -1.0), ("right_deg", 1.0)])
def test_bend_turns_by_its_angle_to_its_side(side, sign):
    rows = generate_route(spec({side: 90, "radius_m": 10, "transition_m": 6}))
    assert rows[-1, 2] == pytest.approx(sign * 90.0, abs=1e-6)
    assert rows[-1, 1] * sign > 0.0, "the y axis of CARLA points to the right"


def test_curvature_is_continuous_and_bounded_by_the_radius():
    s, curvature = curvature_profile(
        [{"straight_m": 5}, {"left_deg": 90, "radius_m": 4, "transition_m": 3}, {"straight_m": 5}]
    )
    assert curvature.max() == 0.25
    assert (np.diff(s) > 0.0).all()
    assert np.sum(0.5 * (curvature[1:] + curvature[:-1]) * np.diff(s)) == pytest.approx(math.pi / 2)


@pytest.mark.parametrize(
    ("element", "part"),
    [
        ({"straigth_m": 5}, "straight_m"),
        ({"straight_m": -5}, "positive"),
        ({"straight_m": "long"}, "positive"),
        (None, "straight_m"),
        ({"left_deg": 10, "radius_m": 10, "transition_m": 6}, "shorten transition_m to 1.7"),
        ({"left_deg": 90}, "radius_m"),
    ],
)
def test_error_names_the_element(element, part):
    with pytest.raises(RouteSpecError, match=part) as caught:
        generate_route(spec({"straight_m": 5}, element))
    assert "element 2" in str(caught.value)


def test_packaged_route_is_drawn_from_its_list(tmp_path):
    path = tmp_path / "route.csv"
    assert run(*SCRIPT, os.path.join(FOLDER, "town.yaml"), path).returncode == 0
    with open(os.path.join(FOLDER, "waypoints.csv"), encoding="utf-8") as file:
        assert path.read_text() == file.read()


def test_packaged_route_has_its_documented_length_and_bends():
    with open(os.path.join(FOLDER, "town.yaml"), encoding="utf-8") as file:
        elements = yaml.safe_load(file)["elements"]
    rows = np.loadtxt(os.path.join(FOLDER, "waypoints.csv"), delimiter=",")
    steps = np.hypot(*np.diff(rows[:, :2], axis=0).T)
    assert 950.0 < steps.sum() < 1050.0
    assert np.abs(steps - 1.0).max() < 0.05
    assert min(element.get("radius_m", 99) for element in elements) == 4
    apart = np.hypot(rows[:, None, 0] - rows[None, :, 0], rows[:, None, 1] - rows[None, :, 1])
    later = np.subtract.outer(np.arange(len(rows)), np.arange(len(rows))) > 50
    assert apart[later].min() < 0.5, "the roundabout does not meet itself"


def test_bad_file_is_reported_in_one_line(tmp_path):
    path = tmp_path / "route.yaml"
    path.write_text("elements: []\n")
    done = run(*SCRIPT, path, tmp_path / "out.csv")
    assert done.returncode == 1
    assert len(done.stdout.splitlines()) == 1
    assert str(path) in done.stdout
