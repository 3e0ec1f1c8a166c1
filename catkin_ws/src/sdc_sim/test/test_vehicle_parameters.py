"""Presets of vehicles are read, and every wrong value is refused with its name and the fix."""

import os

import pytest
import yaml

from sdc_common.validation import DocumentError
from sdc_sim.physics.vehicle_parameters import load_vehicle

PRESET_FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "config", "vehicles")


def preset_with(tmp_path, key, line):
    """Return the path of a preset in which one key has another line, or none."""
    with open(os.path.join(PRESET_FOLDER, "tesla_model3.yaml"), encoding="utf-8") as file:
        lines = [text.split("#")[0].rstrip() for text in file if ":" in text.split("#")[0]]
    lines = [line if text.split(":")[0] == key else text for text in lines]
    path = tmp_path / "bad.yaml"
    path.write_text("\n".join(text for text in lines if text is not None) + "\n")
    return str(path)


with open(os.path.join(os.path.dirname(__file__), "data", "preset_mistakes.yaml")) as table:
    MISTAKES = yaml.safe_load(table)


@pytest.mark.parametrize(("key", "line", "message"), MISTAKES)
def test_invalid_preset_is_refused_in_one_line(tmp_path, key, line, message):
    path = preset_with(tmp_path, key, line)
    with pytest.raises(DocumentError) as caught:
        load_vehicle(path)
    assert "\n" not in str(caught.value) and str(caught.value).startswith(f"{path}, line ")
    assert message in str(caught.value)
