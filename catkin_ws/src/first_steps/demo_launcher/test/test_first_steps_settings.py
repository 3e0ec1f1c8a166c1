"""Test that each node names an invalid or a missing parameter, and the fix."""

import functools
import math
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
from first_steps_shapes import packaged

from qt_interface.settings import read_settings as read_window_settings
from world.rules import checked
from world.rules import read_settings as read_world_settings

READERS = {
    "world": read_world_settings,
    "driverless": functools.partial(checked, "driverless"),
    "qt_interface": read_window_settings,
}

SPECIAL = {
    "world": [
        *(("waypoint_count", value) for value in (1, 2.5, 65537, "many", True)),
        ("start_x", 400.0),
        ("start_y", -225.0),
        ("start_x", "left"),
        ("sensor_front_only", 1),
        ("waypoints_path", 5),
        ("waypoints_period", 3.5),
        ("field_width", 20.0),
    ],
    "driverless": [("turn_gain", 1.1), ("max_turn", 4), ("search_patience", 1.5), ("use_map", 1)],
    "qt_interface": [("trail_points", 2.5), ("window_width", 100.5)],
}
ALL = [(package, name) for package in SPECIAL for name in packaged(package)]
BAD = [(package, *row) for package, rows in SPECIAL.items() for row in rows] + [
    (package, name, value)
    for package, name in ALL
    if isinstance(packaged(package)[name], float) and not name.startswith("start_")
    for value in (0, -3.0, math.nan, "wide", True)
]


@pytest.mark.parametrize("package, name, value", BAD)
def test_error_for_an_invalid_parameter_names_it_and_the_fix(package, name, value):
    with pytest.raises(ValueError, match=rf"^parameter ~{name} is .*: .*(give|make) .*$"):
        READERS[package](packaged(package, **{name: value}))


@pytest.mark.parametrize("package, name", ALL)
def test_error_for_a_missing_parameter_names_it(package, name):
    parameters = packaged(package)
    del parameters[name]
    with pytest.raises(ValueError, match=f"^parameter ~{name} is missing: load config/{package}"):
        READERS[package](parameters)
