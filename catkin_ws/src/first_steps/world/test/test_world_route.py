"""Test the sources of waypoints and the validation of parameters."""

from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from world.car import Field
from world.settings import read_settings
from world.simulation import Simulation
from world.waypoints import Waypoint, check_route, ellipse, load_csv

PACKAGE = Path(__file__).resolve().parents[1]
CONFIG = yaml.safe_load((PACKAGE / "config" / "world.yaml").read_text())
FIELD = Field(800.0, 450.0, 20.0)


@given(st.integers(2, 500), st.floats(1.0, 1e4), st.floats(1.0, 1e4))
def test_ellipse_points_are_on_the_ellipse_in_order_of_idx(count, width, height):
    points = ellipse(count, width, height)
    assert [point.idx for point in points] == list(range(count))
    assert points[0][1:] == (width / 2.0, 0.0)
    for _, x, y in points:
        assert (2.0 * x / width) ** 2 + (2.0 * y / height) ** 2 == pytest.approx(1.0)


def test_packaged_csv_file_is_a_valid_route():
    path = str(PACKAGE / "data" / "figure_eight.csv")
    assert len(Simulation(read_settings({**CONFIG, "waypoints_path": path})).waypoints) == 36


@pytest.mark.parametrize(
    "text, points",
    [
        ("1,2\n3,4\n", [(0, 1.0, 2.0), (1, 3.0, 4.0)]),
        ("x,y\n1,2\n3,4", [(0, 1.0, 2.0), (1, 3.0, 4.0)]),
        ("1,2,9.5,fast\n\n3,4,1,slow\n\n", [(0, 1.0, 2.0), (1, 3.0, 4.0)]),
        ("\ufeffidx, x, y\r\n7,1,2\r\n7,3,4\r\n", [(7, 1.0, 2.0), (7, 3.0, 4.0)]),
        ("y,x\n1,2\n", [(0, 2.0, 1.0)]),
        ("", []),
        ("x,y\n", []),
    ],
)
def test_load_csv_reads_valid_files(tmp_path, text, points):
    path = tmp_path / "route.csv"
    path.write_text(text, encoding="utf-8")
    assert load_csv(str(path)) == points


@pytest.mark.parametrize(
    "text, row, fix",
    [
        ("1,2\n3,nan\n", 2, "x,y in plain numbers"),
        ("x,y\n1,2\ninf,4\n", 3, "x,y in plain numbers"),
        ("1,2\n3\n", 2, "x,y in plain numbers"),
        ("1,2\nthree,4\n", 2, "x,y in plain numbers"),
        ("a,b\n1,2\n", 1, "call the columns x,y"),
        ("idx,x,y\n-1,2,3\n", 2, "0..65535"),
        ("idx,x,y\n65536,2,3\n", 2, "0..65535"),
        ("idx,x,y\n1.5,2,3\n", 2, "0..65535"),
    ],
)
def test_error_for_an_invalid_row_names_it_and_the_fix(tmp_path, text, row, fix):
    path = tmp_path / "route.csv"
    path.write_text(text)
    with pytest.raises(ValueError) as error:
        load_csv(str(path))
    message = str(error.value)
    assert message.startswith(f"{path}: row {row}: ") and fix in message and "\n" not in message


@pytest.mark.parametrize(
    "make",
    [lambda path: None, lambda path: path.mkdir(), lambda path: path.write_bytes(b"\xff\xfe\x00")],
)
def test_error_for_an_unreadable_file_names_the_parameter(tmp_path, make):
    make(tmp_path / "route.csv")
    with pytest.raises(ValueError, match=r"^waypoints_path .*route\.csv: .*give a readable CSV"):
        load_csv(str(tmp_path / "route.csv"))


@pytest.mark.parametrize(
    "points, fix",
    [
        ([], "at least 2"),
        ([Waypoint(0, 1.0, 1.0)], "at least 2"),
        ([Waypoint(0, 0.0, 0.0), Waypoint(1, 400.5, 0.0)], "outside the walls"),
        ([Waypoint(0, 0.0, -226.0), Waypoint(1, 0.0, 0.0)], "outside the walls"),
        ([Waypoint(0, 0.0, 0.0), Waypoint(1, 20.0, 0.0)], "spread them"),
    ],
)
def test_check_route_refuses_routes_without_possible_laps(points, fix):
    with pytest.raises(ValueError, match=f"^route.csv: .*{fix}"):
        check_route(points, FIELD, 25.0, "route.csv")


def test_simulation_refuses_an_ellipse_larger_than_the_field():
    with pytest.raises(ValueError, match=r"~ellipse_width 900.*outside the walls"):
        Simulation(read_settings({**CONFIG, "ellipse_width": 900.0}))
