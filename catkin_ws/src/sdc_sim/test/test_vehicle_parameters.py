"""Presets of vehicles are read, and every wrong value is refused with its name and the fix."""

from __future__ import annotations

import os

import pytest

from sdc_sim.physics.vehicle_parameters import load_vehicle
from sdc_sim.yaml_document import DocumentError

PRESET_FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "config", "vehicles")


def preset_with(tmp_path, key, line):
    """Return the path of a preset in which one key has another line, or none."""
    with open(os.path.join(PRESET_FOLDER, "tesla_model3.yaml"), encoding="utf-8") as file:
        lines = [text.split("#")[0].rstrip() for text in file if ":" in text.split("#")[0]]
    lines = [line if text.split(":")[0] == key else text for text in lines]
    path = tmp_path / "bad.yaml"
    path.write_text("\n".join(text for text in lines if text is not None) + "\n")
    return str(path)


POSITIVE = "'mass_kg' must be a positive number up to 1e9, got "
LIST = "must be a list of two numbers or more, such as [0.0, 1.0], got "


@pytest.mark.parametrize(
    ("key", "line", "message"),
    [
        ("mass_kg", None, "key 'mass_kg' is missing in the file; add the line 'mass_kg: ...'"),
        ("mass_kg", "mas_kg: 1845.0", "unknown key 'mas_kg'; did you mean 'mass_kg'?"),
        ("mass_kg", "mass_kg: -1845.0", POSITIVE + "-1845.0"),
        ("mass_kg", "mass_kg: 1e-10", POSITIVE + "1e-10"),
        ("mass_kg", "mass_kg: 1e10", POSITIVE + "10000000000.0"),
        ("mass_kg", "mass_kg: .nan", POSITIVE + "nan"),
        ("mass_kg", "mass_kg: heavy", POSITIVE + "'heavy'"),
        ("mass_kg", "mass_kg:", POSITIVE + "nothing"),
        ("steer_shares", "steer_shares: 1.0", "'steer_shares' " + LIST + "1.0"),
        ("steer_shares", "steer_shares: [1, 0.9]", "'steer_shares' must have as many entries as"),
        ("steer_shares", "steer_shares: [1, 0, 1, 1]", "must be a share above 0 and at most 1"),
        ("steer_speeds_mps", "steer_speeds_mps: [0, 9, 5, 30]", "must rise from entry to entry"),
        ("brake_front_share", "brake_front_share: 1.5", "must be a number from 0 to 1, got 1.5"),
        ("pedal_grip_share", "pedal_grip_share: 1.1", "must be a share above 0 and at most 1"),
        ("drag_area_m2", "drag_area_m2: -0.1", "must be a number from 0 to 1e+09, got -0.1"),
        ("max_wheel_angle_rad", "max_wheel_angle_rad: 70", "less than 90 degrees, 1.5708 rad"),
        ("tyre_shape", "tyre_shape: 2.0", "'tyre_shape' must be between 1 and 2 (usual: 1.3)"),
        ("throttle_points", "throttle_points: [0, 0.3, 0.5, 0.9]", "must start at 0 and end at 1"),
        ("drive_forces_n", "drive_forces_n: [0, -1, 2, 3]", "entry 2 of 'drive_forces_n' must be"),
        ("drive_forces_n", "drive_forces_n: [0, 9, 5, 10]", "must start at 0 and never fall"),
    ],
)
def test_invalid_preset_is_refused_in_one_line(tmp_path, key, line, message):
    path = preset_with(tmp_path, key, line)
    with pytest.raises(DocumentError) as caught:
        load_vehicle(path)
    assert "\n" not in str(caught.value) and str(caught.value).startswith(f"{path}, line ")
    assert message in str(caught.value)
