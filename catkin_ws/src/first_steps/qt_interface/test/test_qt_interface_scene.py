"""Test the parts of the window that do not use Qt: scene and settings."""

import math
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from qt_interface.scene import PIECE, Point, Scene
from qt_interface.settings import SettingsError, read_settings, read_world_sizes

CONFIG = yaml.safe_load(
    (Path(__file__).resolve().parents[1] / "config" / "qt_interface.yaml").read_text()
)


def drive(scene, *xs):
    for x in xs:
        scene.set_car(float(x), 0.0, 0.0, float(x))


@given(st.integers(1, 1000))
def test_pieces_of_the_trail_join_and_the_newest_one_is_short(count):
    scene = Scene(read_settings(CONFIG))
    drive(scene, *range(count))
    pieces = [*scene.trail_pieces(), scene.newest_trail()]
    assert len(pieces) == scene.trail_count // PIECE + 1
    assert all(len(piece) <= PIECE + 1 for piece in pieces)
    for before, after in zip(pieces, pieces[1:]):
        assert before[-1] == after[0]
    xs = [0.0] + [x for piece in pieces for x, _ in piece[1:]]
    assert xs == [float(x) for x in range(count)]


@given(st.integers(1, 600), st.integers(1, 2000))
def test_trail_never_exceeds_its_limit(limit, count):
    scene = Scene(read_settings({**CONFIG, "trail_points": limit}))
    drive(scene, *range(count))
    points = [point for piece in scene.trail_pieces() for point in piece[:-1]]
    points += scene.newest_trail()
    assert points == [(float(x), 0.0) for x in range(max(count - limit, 0), count)]


def test_cleared_trail_is_empty_and_changes_the_version():
    scene = Scene(read_settings(CONFIG))
    drive(scene, *range(300))
    version = scene.version
    scene.clear_trail()
    assert [*scene.trail_pieces(), *scene.newest_trail()] == [] and scene.version != version


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
