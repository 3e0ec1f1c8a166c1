"""Where the car is in its lane, from masks of a straight road, and a path that follows it."""

import numpy as np
import pytest

from sdc_common.configuration import node_config
from sdc_common.geometry.polyline import Place
from sdc_package.lane_offset import LaneFit, LaneHold

# The front camera: ahead of the vehicle's centre, above the ground, tilted downward.
AHEAD_M = 0.7
ABOVE_M = 1.7
DOWN_RAD = np.pi / 360.0
LANE = LaneFit(**node_config("sdc_package", "camera")["lane_offset"])


def mask_of_lane(offset_m, heading_rad=0.0, lines_m=(-1.75, 1.75)):
    """Return the mask of a straight lane with these lines, seen from a car in it."""
    mask = np.zeros((480, 640), np.uint8)
    for line_m in lines_m:
        for side_m in (-0.07, 0.07):  # the filter marks both sides of a line
            columns, rows = pixels_of_line(line_m + side_m - offset_m, heading_rad)
            seen = (columns >= 0) & (columns < 640) & (rows >= 0) & (rows < 480)
            mask[rows[seen], columns[seen]] = 255
    return mask


def pixels_of_line(left_m, heading_rad):
    """Return columns and rows of a line along the road in a picture of 640 x 480 over 90 degrees.

    Args:
        left_m: the line's distance on the left of the vehicle's centre [m]
        heading_rad: heading of the vehicle relative to the line [rad]
    """
    along_m = np.linspace(0.0, 40.0, 4000)
    forward_m = np.cos(heading_rad) * along_m + np.sin(heading_rad) * left_m - AHEAD_M
    right_m = np.sin(heading_rad) * along_m - np.cos(heading_rad) * left_m
    depth_m = np.cos(DOWN_RAD) * forward_m + np.sin(DOWN_RAD) * ABOVE_M
    down_m = np.cos(DOWN_RAD) * ABOVE_M - np.sin(DOWN_RAD) * forward_m
    in_front = depth_m > 0.01
    x, y = right_m[in_front] / depth_m[in_front], down_m[in_front] / depth_m[in_front]
    return np.round(320.0 + 320.0 * x).astype(int), np.round(240.0 + 320.0 * y).astype(int)


@pytest.mark.parametrize("offset_m", (-0.6, 0.0, 0.4))
@pytest.mark.parametrize("lines_m", ((-1.75, 1.75), (-1.75,), (-1.75, 1.75, 5.25, -2.6)))
def test_offset_is_positive_left_of_the_middle(offset_m, lines_m):
    for heading_rad in (-0.04, 0.0, 0.04):
        found_m = LANE.measure(mask_of_lane(offset_m, heading_rad, lines_m))
        assert found_m == pytest.approx(offset_m, abs=0.08)


def test_without_a_lane_there_is_no_offset():
    assert LANE.measure(np.zeros((480, 640), np.uint8)) is None
    assert LANE.measure(mask_of_lane(0.0, 0.2)) is None, "the lane of a narrow bend"


def test_path_moves_to_the_lane_that_the_camera_sees():
    hold, rows = LaneHold(), np.array([(x, 0.0, 5.0) for x in range(10)])
    place = Place(0, 0.0, cross_track_m=0.5, heading_rad=0.0)
    for stamp in range(100):
        moved = hold.moved(rows, stamp, place)
        hold.see(stamp, 0.1)
        hold.see(stamp + 1000, 9.0)  # of a picture whose odometry is unknown
    np.testing.assert_allclose(moved, rows + (0.0, 0.4, 0.0), atol=1e-3)
