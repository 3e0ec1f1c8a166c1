"""Test the parts of the window that do not use Qt: view, trail, scene and settings."""

import math
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from qt_interface.scene import PIECE_LENGTH, Point, Scene, Trail
from qt_interface.settings import SettingsError, read_settings, read_world_sizes
from qt_interface.view import SCALE_MAX, SCALE_MIN, View, fit, nice_step

CONFIG = yaml.safe_load(
    (Path(__file__).resolve().parents[1] / "config" / "qt_interface.yaml").read_text()
)
lengths = st.floats(-1e4, 1e4)
views = st.builds(
    View,
    lengths,
    lengths,
    st.floats(SCALE_MIN, SCALE_MAX),
    st.integers(1, 4000),
    st.integers(1, 4000),
)


@given(views, lengths, lengths)
def test_to_field_is_the_inverse_of_to_pixel(view, x, y):
    assert view.to_field(*view.to_pixel(x, y)) == (
        pytest.approx(x, abs=1e-6),
        pytest.approx(y, abs=1e-6),
    )


def test_y_points_up_on_the_field_and_down_on_the_screen():
    view = View(0.0, 0.0, 2.0, 100, 100)
    assert view.to_pixel(10.0, 10.0) == (70.0, 30.0)


@given(views, st.floats(0.1, 10.0), st.floats(0, 4000), st.floats(0, 4000))
def test_zoom_keeps_the_field_point_at_the_mouse(view, factor, pixel_x, pixel_y):
    x, y = view.to_field(pixel_x, pixel_y)
    zoomed = view.zoomed(factor, pixel_x, pixel_y)
    assert SCALE_MIN <= zoomed.scale <= SCALE_MAX
    assert zoomed.to_pixel(x, y) == (
        pytest.approx(pixel_x, abs=1e-3),
        pytest.approx(pixel_y, abs=1e-3),
    )


@given(views, lengths, lengths)
def test_pan_moves_the_field_with_the_mouse(view, pixels_x, pixels_y):
    before = view.to_pixel(3.0, 4.0)
    after = view.panned(pixels_x, pixels_y).to_pixel(3.0, 4.0)
    assert after == (
        pytest.approx(before[0] + pixels_x, abs=1e-5),
        pytest.approx(before[1] + pixels_y, abs=1e-5),
    )


@given(st.lists(st.tuples(st.floats(-900, 900), st.floats(-900, 900)), max_size=20))
def test_fit_shows_all_points_within_the_margin(points):
    view = fit(points, 600, 400, 30)
    for x, y in points:
        pixel_x, pixel_y = view.to_pixel(x, y)
        assert 30 - 1e-6 <= pixel_x <= 570 + 1e-6 and 30 - 1e-6 <= pixel_y <= 370 + 1e-6


@given(st.floats(1e-3, 1e6))
def test_nice_step_is_at_most_the_length(length):
    step = nice_step(length)
    assert step <= length * (1 + 1e-9) and step > length / 2.6


def test_trail_pieces_join_and_never_change():
    trail = Trail(10000, 50.0)
    for i in range(2 * PIECE_LENGTH):
        trail.add(float(i), 0.0)
    first = list(trail.finished[0])
    for i in range(2 * PIECE_LENGTH, 4 * PIECE_LENGTH):
        trail.add(float(i), 0.0)
    assert trail.finished[0] == first and len(first) == PIECE_LENGTH
    for before, after in zip(trail.finished, trail.finished[1:] + [trail.growing]):
        assert before[-1] == after[0]


def test_jump_interrupts_the_trail():
    trail = Trail(100, 50.0)
    for x in (0.0, 10.0, 200.0, 210.0):
        trail.add(x, 0.0)
    assert trail.finished == [[(0.0, 0.0), (10.0, 0.0)]]
    assert trail.growing == [(200.0, 0.0), (210.0, 0.0)]


@given(st.integers(200, 600), st.integers(0, 2000))
def test_trail_never_exceeds_its_limit(limit, count):
    trail = Trail(limit, 50.0)
    for i in range(count):
        trail.add(float(i), 0.0)
        assert len(trail) <= limit
    if count:
        assert trail.growing[-1] == (float(count - 1), 0.0)


def test_clear_changes_the_version_of_the_trail():
    trail = Trail(100, 50.0)
    trail.add(1.0, 2.0)
    version = trail.version
    trail.clear()
    assert len(trail) == 0 and trail.version != version


def test_car_at_interpolates_the_last_two_positions():
    scene = Scene(read_settings(CONFIG))
    scene.set_car(0.0, 0.0, 3.1, 10.0)
    scene.set_car(4.0, 0.0, -3.1, 10.04)
    assert scene.car_at(10.04).x == 0.0
    assert scene.car_at(10.06).x == pytest.approx(2.0)
    assert scene.car_at(10.06).direction == pytest.approx(math.pi), "the shortest way round"
    assert scene.car_at(10.08).x == pytest.approx(4.0)
    assert scene.car_at(99.0).x == 4.0


def test_car_at_does_not_interpolate_a_jump():
    scene = Scene(read_settings(CONFIG))
    scene.set_car(0.0, 0.0, 0.0, 10.0)
    scene.set_car(300.0, 0.0, 0.0, 10.03)
    assert scene.car_at(10.03).x == 300.0


def test_scene_without_world_sizes_has_no_walls():
    scene = Scene(read_settings(CONFIG))
    assert scene.contains(1e6, -1e6) and scene.corners() == [] and scene.walls is None
    scene.set_world(read_world_sizes({}), [Point(1, 5.0, 6.0)])
    assert scene.corners() == [(5.0, 6.0)]
    for x, y in ((1.0, 2.0), (-1.0, 9.0)):
        scene.set_car(x, y, 0.0, 0.0)
    assert scene.corners() == [(5.0, 6.0), (-1.0, 2.0), (1.0, 9.0)], (
        "all positions of the car stay in view"
    )
    scene.set_world(read_world_sizes({"field_width": 10, "field_height": 8.0}), [])
    assert scene.contains(5.0, 4.0) and not scene.contains(5.1, 0.0)


@pytest.mark.parametrize(
    "name, value",
    [(name, value) for name in CONFIG for value in (0, -1, math.nan, "x", True)]
    + [("trail_points", 2.5), ("window_width", 100.5)],
)
def test_error_for_an_invalid_parameter_names_it_and_the_fix(name, value):
    with pytest.raises(SettingsError, match=rf"^parameter ~{name} is .*: give a"):
        read_settings({**CONFIG, name: value})


@pytest.mark.parametrize("name", sorted(CONFIG))
def test_error_for_a_missing_parameter_names_it(name):
    with pytest.raises(SettingsError, match=f"~{name} is missing"):
        read_settings({key: value for key, value in CONFIG.items() if key != name})


def test_invalid_world_sizes_are_none():
    sizes = read_world_sizes(
        {"field_width": -1.0, "field_height": 5, "car_size": "big", "sensor_front_only": True}
    )
    assert sizes == (None, 5, None, None, True)
