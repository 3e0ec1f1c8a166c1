"""The road of the page."""

import json

import numpy as np
import pytest

from sdc_cockpit.road_view import RoadView

# An eight: the route crosses itself in the middle at a right angle.
ANGLE = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
EIGHT = np.column_stack([40.0 * np.sin(ANGLE), 40.0 * np.sin(ANGLE) * np.cos(ANGLE)])


def test_cross_track_error_at_a_crossing_is_that_of_the_own_pass():
    road = RoadView(EIGHT)
    yaws = np.arctan2(*np.diff(EIGHT, axis=0).T[::-1])
    beside = EIGHT[: len(yaws)] + 0.5 * np.column_stack([-np.sin(yaws), np.cos(yaws)])
    errors = [road.cross_track_m(x, y, yaw) for (x, y), yaw in zip(beside.tolist(), yaws)]
    assert np.abs(np.array(errors) - 0.5).max() < 0.05


def test_car_that_is_placed_elsewhere_is_found_again():
    road = RoadView(EIGHT)
    road.cross_track_m(*EIGHT[10], 0.0)
    assert road.cross_track_m(*EIGHT[300], 0.0) == pytest.approx(0.0, abs=1e-6)


def test_road_is_drawn_from_flat_lists_of_numbers():
    road = json.loads(RoadView(EIGHT).to_json())
    assert len(road["route"]) == 2 * len(EIGHT)
    assert len(road["surface"]) % 8 == len(road["edges"]) % 4 == len(road["dashes"]) % 4 == 0
    assert min(len(part) for part in road.values()) > 0
