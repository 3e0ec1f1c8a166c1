"""Tests of the map view."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_sim.manual_control.map_view import MapView

STRAIGHT = np.column_stack([np.arange(0.0, 101.0), np.zeros(101)])
GRASS = (70, 105, 80)
pose = st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.floats(-math.pi, math.pi))


def colour_at(view, picture, point, pose):
    column, row = np.round(view.to_pixels(point, *pose)).astype(int)
    return tuple(int(value) for value in picture[row, column])


@given(pose, st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))
def test_map_is_drawn_heading_up(pose, forward_m, left_m):
    x, y, yaw = pose
    view = MapView(0.25, 10.0)
    point = (
        x + math.cos(yaw) * forward_m - math.sin(yaw) * left_m,
        y + math.sin(yaw) * forward_m + math.cos(yaw) * left_m,
    )
    np.testing.assert_allclose(
        view.to_pixels(point, *pose), (320.0 - left_m / 0.25, 336.0 - forward_m / 0.25), atol=1e-6
    )


@pytest.mark.parametrize("pose", [(20.0, 0.0, 0.0), (20.0, 1.0, 0.5), (50.0, -2.0, math.pi)])
def test_road_path_and_obstacles_are_drawn_at_their_positions(pose):
    view = MapView(0.1, 10.0)
    view.set_route(STRAIGHT)
    x, y, yaw = pose
    ahead = x + math.copysign(12.0, math.cos(yaw))
    plain = view.picture(*pose)
    assert plain.shape == (480, 640, 3) and plain.dtype == np.uint8
    assert colour_at(view, plain, (ahead, 0.0), pose) == (78, 76, 74)
    assert min(colour_at(view, plain, (ahead, -1.75), pose)) > 120
    assert colour_at(view, plain, (ahead, -4.0), pose) == GRASS
    full = view.picture(
        *pose,
        path=[(x, 0.0, 10.0), (ahead + 1.0, 0.0, 10.0), (ahead - 1.0, 0.0, 10.0)],
        obstacles=[(ahead, -4.0, 0.3, 2.0, 1.0)],
    )
    blue, green, red = colour_at(view, full, (ahead, 0.0), pose)
    assert green > 150 > max(blue, red)
    assert colour_at(view, full, (ahead, -4.0), pose) == (30, 130, 240)


def test_car_is_drawn_without_a_road():
    view = MapView(0.1, 10.0)
    picture = view.picture(1.0, 2.0, 3.0)
    assert colour_at(view, picture, (1.0, 2.0), (1.0, 2.0, 3.0)) != GRASS
    assert tuple(picture[0, 0]) == GRASS


def test_rows_that_are_not_finite_are_ignored():
    view = MapView(0.1, 10.0)
    bad = view.picture(
        0.0,
        0.0,
        0.0,
        path=[(math.nan, 0.0, 1.0), (math.inf, 1.0, 1.0)],
        obstacles=[(math.nan,) * 5],
    )
    np.testing.assert_array_equal(bad, view.picture(0.0, 0.0, 0.0))
    good = [(5.0, 1.0, 3.0), (15.0, 0.0, 6.0)]
    mixed = view.picture(0.0, 0.0, 0.0, path=[good[0], (math.nan, 0.0, 1.0), good[1]])
    np.testing.assert_array_equal(mixed, view.picture(0.0, 0.0, 0.0, path=good))
    assert (mixed != bad).any()


def test_invalid_route_scale_and_speed_are_refused():
    view = MapView(0.1, 10.0)
    with pytest.raises(ValueError, match="route"):
        view.set_route([(0.0, 0.0)])
    with pytest.raises(ValueError, match="scale"):
        MapView(0.0, 10.0)
    with pytest.raises(ValueError, match="green"):
        MapView(0.1, 0.0)
