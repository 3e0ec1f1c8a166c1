import numpy as np
import pytest

from sdc_sim.road.road import MARGIN_M, Road
from sdc_sim.road.road_markings import road_markings, speed_colours

STRAIGHT = np.column_stack([np.arange(0.0, 101.0), np.zeros(101)])


def test_lines_of_a_straight_road_lie_at_their_offsets():
    road = Road(STRAIGHT)
    markings = road_markings(road)
    assert {round(float(y), 3) for y in markings.edges[:, :, 1].ravel()} == {
        road.right_edge_m,
        road.left_edge_m,
    }
    assert {round(float(y), 3) for y in markings.dashes[:, :, 1].ravel()} == {road.centre_line_m}
    np.testing.assert_allclose(markings.dashes[:, 1, 0] - markings.dashes[:, 0, 0], 3.0)


def test_surface_of_a_straight_road_has_its_area():
    road = Road(STRAIGHT)
    x, y = np.moveaxis(road_markings(road).surface, 2, 0)
    area = (
        0.5 * np.abs(np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)).sum()
    )
    assert area == pytest.approx(
        (road.s_m[-1] - road.s_m[0]) * (2.0 * road.lane_width_m + 2.0 * MARGIN_M)
    )


def test_colours_run_from_red_over_yellow_to_green():
    red, half, green, beyond = speed_colours([0.0, 5.0, 10.0, 30.0], 10.0)
    assert red[0] > 0.8 > red[1]
    assert half[0] > 0.8 and half[1] > 0.7
    assert green[1] > 0.7 > green[0]
    np.testing.assert_array_equal(green, beyond)
    assert speed_colours([], 10.0).shape == (0, 3)
