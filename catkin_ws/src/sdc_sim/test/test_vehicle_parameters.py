"""Presets of vehicles are read, and every wrong value is refused with its name and the fix."""

from __future__ import annotations

import dataclasses
import math
import os

import pytest

from sdc_sim.physics.vehicle_parameters import VehicleError, load_vehicle

PRESET_FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "config", "vehicles")
CAR = load_vehicle(os.path.join(PRESET_FOLDER, "tesla_model3.yaml"))


# The message of a value that is refused has this form; its error has the key.
BAD_VALUES = [
    ("max_wheel_angle_rad", 0.5 * math.pi, "^must be less than 90 degrees.* rad$"),
    ("steer_effectiveness", 1.1, "^is a share .* got 1.1$"),
    ("pedal_grip_share", 1.1, "^is a share .* got 1.1$"),
    ("tyre_shape", 1.0, "^must be between 1 and 2 .* got 1$"),
    ("tyre_shape", 2.0, "^must be between 1 and 2 .* got 2$"),
    ("tyre_shape", 2.5, "^must be between 1 and 2 .* got 2.5$"),
    ("mass_kg", 1e10, r"^is 1e\+10: give 0, or 1e-09 to 1e\+09$"),
    ("mass_kg", 1e-10, r"^is 1e-10: give 0, or 1e-09 to 1e\+09$"),
    ("mass_kg", None, "^is empty: give a number$"),
    ("mass_kg", True, "^is a truth value: give a number$"),
    ("mass_kg", [1.0], "^is a list: give a number$"),
    ("mass_kg", {1.0: 2.0}, "^is a mapping: give a number$"),
    ("mass_kg", (1.0,), r"^is \(1\.0,\): give a number$"),
    ("steer_shares", 1.0, r"^must be a list of two numbers.* \[0\.0, 1\.0\]$"),
    ("steer_shares", [1.0, 0.9, 0.8, 0.0], "^must be above 0 and at most 1$"),
    ("steer_shares", [1.2, 0.9, 0.8, 0.7], "^must be above 0 and at most 1$"),
    ("steer_speeds_mps", [0.0, 5.0, 5.0, 30.0], "^must rise from entry to entry$"),
    ("throttle_points", [0.1, 0.3, 0.5, 1.0], "^must start at 0 and end at 1$"),
    ("drive_forces_n", [1.0, 2.0, 3.0, 4.0], "^must start at 0 and never fall$"),
]


@pytest.mark.parametrize(("key", "value", "message"), BAD_VALUES)
def test_value_that_is_refused_is_named(key, value, message):
    with pytest.raises(VehicleError, match=message) as caught:
        dataclasses.replace(CAR, **{key: value})
    assert caught.value.key == key


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("mass_kg", 1e9),
        ("mass_kg", 1e-9),
        ("drive_forces_n", (0.0, 5.0, 5.0, 9.0)),
        ("steer_effectiveness", 1.0),
        ("brake_front_share", 1.0),
        ("brake_front_share", 0.0),
        ("drag_area_m2", 0.0),
    ],
)
def test_value_at_the_limit_is_accepted(key, value):
    assert getattr(dataclasses.replace(CAR, **{key: value}), key) == value


def good_preset_lines():
    with open(os.path.join(PRESET_FOLDER, "tesla_model3.yaml"), encoding="utf-8") as file:
        return [line.split("#")[0].rstrip() for line in file if ":" in line.split("#")[0]]


# (title, key whose line is replaced, new line or None to remove it, words in the message)
BAD_PRESETS = [
    ("missing key", "mass_kg", None, ["'mass_kg'", "missing", "add the line"]),
    ("misspelt key", "mass_kg", "mas_kg: 1845.0", ["line 1", "'mas_kg'", "did you mean 'mass_kg'"]),
    ("alien key", "mass_kg", "mass_kg: 1845.0\nzebra: 1", ["line 2", "'zebra'", "remove it"]),
    (
        "key given twice",
        "mass_kg",
        "mass_kg: 1845.0\nmass_kg: 1800.0",
        ["line 2", "mass_kg", "duplicate", "correct it"],
    ),
    ("negative", "mass_kg", "mass_kg: -1845.0", ["line 1", "'mass_kg'", "positive", "-1845"]),
    (
        "zero",
        "yaw_inertia_kgm2",
        "yaw_inertia_kgm2: 0",
        ["line 2", "'yaw_inertia_kgm2'", "positive"],
    ),
    ("NaN", "mass_kg", "mass_kg: .nan", ["line 1", "'mass_kg'", "finite"]),
    ("infinity", "mass_kg", "mass_kg: .inf", ["line 1", "'mass_kg'", "finite"]),
    ("astronomic", "mass_kg", "mass_kg: 1" + "0" * 400, ["line 1", "'mass_kg'", "finite"]),
    ("word", "mass_kg", "mass_kg: heavy", ["line 1", "'mass_kg'", "word 'heavy'", "give a number"]),
    ("truth value", "mass_kg", "mass_kg: yes", ["'mass_kg'", "give a number"]),
    ("empty", "mass_kg", "mass_kg:", ["'mass_kg'", "empty", "give a number"]),
    ("list for a number", "mass_kg", "mass_kg: [1, 2]", ["'mass_kg'", "a list"]),
    ("number for a list", "steer_shares", "steer_shares: 1.0", ["'steer_shares'", "list of two"]),
    (
        "word in a list",
        "steer_shares",
        "steer_shares: [1.0, b, 0.8, 0.7]",
        ["'steer_shares'", "word 'b'"],
    ),
    (
        "negative in a list",
        "drive_forces_n",
        "drive_forces_n: [0, -1, 2, 3]",
        ["'drive_forces_n'", "negative"],
    ),
    (
        "short list",
        "steer_shares",
        "steer_shares: [1.0, 0.9]",
        ["'steer_shares'", "as many entries"],
    ),
    (
        "falling speeds",
        "steer_speeds_mps",
        "steer_speeds_mps: [0, 9, 5, 30]",
        ["'steer_speeds_mps'", "rise"],
    ),
    (
        "share above one",
        "brake_front_share",
        "brake_front_share: 1.5",
        ["'brake_front_share'", "0..1"],
    ),
    ("drag below zero", "drag_area_m2", "drag_area_m2: -0.1", ["'drag_area_m2'", "negative"]),
    (
        "angle in degrees",
        "max_wheel_angle_rad",
        "max_wheel_angle_rad: 70",
        ["'max_wheel_angle_rad'", "90 degrees"],
    ),
    ("tyre without a shape", "tyre_shape", "tyre_shape: 5", ["'tyre_shape'", "between 1 and 2"]),
    (
        "short throttle",
        "throttle_points",
        "throttle_points: [0, 0.3, 0.5, 0.9]",
        ["'throttle_points'", "end at 1"],
    ),
    (
        "force that falls",
        "drive_forces_n",
        "drive_forces_n: [0, 9, 5, 10]",
        ["'drive_forces_n'", "never fall"],
    ),
    ("broken YAML", "mass_kg", "mass_kg: [1, 2", ["not valid YAML", "line"]),
    (
        "code in YAML",
        "mass_kg",
        "mass_kg: !!python/object/apply:os.getcwd []",
        ["line 1", "'mass_kg'", "a list"],
    ),
]


@pytest.mark.parametrize("title,key,line,words", BAD_PRESETS, ids=[case[0] for case in BAD_PRESETS])
def test_invalid_preset_is_refused_in_one_line(tmp_path, title, key, line, words):
    lines = [line if text.split(":")[0] == key else text for text in good_preset_lines()]
    path = tmp_path / "bad.yaml"
    path.write_text("\n".join(text for text in lines if text is not None) + "\n")
    with pytest.raises(VehicleError) as caught:
        load_vehicle(str(path))
    message = str(caught.value)
    assert "\n" not in message and str(path) in message
    for word in words:
        assert word in message


@pytest.mark.parametrize("content", [b"", b"- 1\n- 2\n", b"hello", b"\xff\xfe\x00\x80", b"a: \x00"])
def test_file_that_is_no_preset_is_refused(tmp_path, content):
    path = tmp_path / "bad.yaml"
    path.write_bytes(content)
    with pytest.raises(VehicleError, match="bad.yaml") as caught:
        load_vehicle(str(path))
    assert "\n" not in str(caught.value)


def test_missing_file_and_folder_are_refused(tmp_path):
    for path in (tmp_path / "absent.yaml", tmp_path):
        with pytest.raises(VehicleError, match="cannot be read"):
            load_vehicle(str(path))


def test_number_that_yaml_reads_as_text_is_converted(tmp_path):
    lines = [
        "mass_kg: 1845e0" if text.startswith("mass_kg") else text for text in good_preset_lines()
    ]
    path = tmp_path / "car.yaml"
    path.write_text("\n".join(lines))
    assert load_vehicle(str(path)) == CAR
