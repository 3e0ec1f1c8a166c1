import numpy as np

from sdc_sim.road.road_markings import speed_colours


def test_colours_run_from_red_over_yellow_to_green():
    red, half, green, beyond = speed_colours([0.0, 5.0, 10.0, 30.0], 10.0)
    assert red[0] > 0.8 > red[1]
    assert half[0] > 0.8 and half[1] > 0.7
    assert green[1] > 0.7 > green[0]
    np.testing.assert_array_equal(green, beyond)
    assert speed_colours([], 10.0).shape == (0, 3)
