"""Test the parts of the window that need no display: scene and settings."""

import math
from pathlib import Path

import pytest
import yaml
from PyQt5.QtCore import QRectF

from qt_interface.scene import Point, Scene
from qt_interface.settings import read_settings, read_world_sizes

CONFIG = yaml.safe_load(
    (Path(__file__).resolve().parents[1] / "config" / "qt_interface.yaml").read_text()
)


def drive(scene, *xs):
    for x in xs:
        scene.set_car(float(x), 0.0, 0.0, float(x))


def test_trail_keeps_the_newest_steps_until_it_is_cleared():
    scene = Scene(read_settings({**CONFIG, "trail_points": 100}))
    drive(scene, *range(300))
    assert [(step.x1(), step.x2()) for step in scene.trail] == [(x, x + 1) for x in range(199, 299)]
    scene.clear_trail()
    assert not scene.trail


def test_car_at_interpolates_the_last_two_positions():
    scene = Scene(read_settings(CONFIG))
    scene.set_car(0.0, 0.0, 3.1, 10.0)
    scene.set_car(4.0, 0.0, -3.1, 10.04)
    assert scene.car_at(10.04).x == 0.0
    assert scene.car_at(10.06).x == pytest.approx(2.0)
    assert scene.car_at(10.06).direction == pytest.approx(math.pi), "the shortest way round"
    assert scene.car_at(10.08).x == pytest.approx(4.0)
    assert scene.car_at(99.0).x == 4.0


def test_jump_is_neither_interpolated_nor_part_of_the_trail():
    scene = Scene(read_settings(CONFIG))
    scene.set_car(0.0, 0.0, 0.0, 10.0)
    scene.set_car(300.0, 0.0, 0.0, 10.03)
    assert scene.car_at(10.03).x == 300.0 and not scene.trail


def test_scene_without_world_sizes_has_no_walls():
    scene = Scene(read_settings(CONFIG))
    assert scene.contains(1e6, -1e6) and scene.walls is None
    scene.set_world(read_world_sizes({}), [Point(1, 5.0, 6.0)])
    assert scene.extent() == QRectF(5.0, 6.0, 0.0, 0.0)
    for x, y in ((1.0, 2.0), (-1.0, 9.0)):
        scene.set_car(x, y, 0.0, 0.0)
    assert scene.extent() == QRectF(-1.0, 2.0, 6.0, 7.0), "the way of the car stays in view"
    scene.set_world(read_world_sizes({"field_width": 10, "field_height": 8.0}), [])
    assert scene.contains(5.0, 4.0) and not scene.contains(5.1, 0.0)


def test_invalid_world_sizes_are_none():
    sizes = read_world_sizes(
        {"field_width": -1.0, "field_height": 5, "car_size": "big", "sensor_front_only": True}
    )
    assert sizes == (None, 5, None, None, True)
