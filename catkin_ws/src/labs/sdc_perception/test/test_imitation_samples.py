import math

import numpy as np
import pytest

from sdc_perception.imitation_samples import (
    REAR_M,
    SHORTEST_LOOK_AHEAD_M,
    Answer,
    DrivenLine,
    arc_path,
    road_view,
)

SPEED_MPS = 4.0
TIMES_S = np.arange(0.0, 10.0, 0.05)


def circle(radius_m):
    """Return the line of a car whose rear axle drives a left bend around (0, radius_m)."""
    yaw = SPEED_MPS * TIMES_S / radius_m
    rear = radius_m * np.column_stack([np.sin(yaw), 1.0 - np.cos(yaw)])
    centre = rear + REAR_M * np.column_stack([np.cos(yaw), np.sin(yaw)])
    return DrivenLine(TIMES_S, np.column_stack([centre, yaw]), np.full(len(yaw), SPEED_MPS))


def test_answer_on_the_line_is_what_the_driver_did():
    assert circle(20.0).answer(50) == pytest.approx((1.0 / 20.0, SPEED_MPS), abs=1e-4)
    assert circle(1e6).answer(50) == pytest.approx((0.0, SPEED_MPS), abs=1e-4)


@pytest.mark.parametrize(("left_m", "turned_rad"), [(0.8, 0.0), (-0.8, 0.0), (0.5, 0.2)])
def test_answer_beside_a_straight_line_leads_back_to_it(left_m, turned_rad):
    line = circle(1e6)
    curvature_1pm, _ = line.answer(50, left_m, turned_rad)
    x, y, yaw = line.displaced(50, left_m, turned_rad)
    rear_x, rear_y = x - REAR_M * math.cos(yaw), y - REAR_M * math.sin(yaw)
    assert rear_y == pytest.approx(left_m, abs=0.01)
    # The end of the arc is on the line, at the look-ahead distance.
    centre = np.array(
        [rear_x - math.sin(yaw) / curvature_1pm, rear_y + math.cos(yaw) / curvature_1pm]
    )
    ahead = np.array([line.poses[50, 0] + SHORTEST_LOOK_AHEAD_M, 0.0])
    assert np.hypot(*(ahead - centre)) == pytest.approx(abs(1.0 / curvature_1pm), abs=0.01)


@pytest.mark.parametrize("curvature_1pm", [0.1, -0.05, 1e-9])
def test_rear_axle_of_the_path_drives_the_arc(curvature_1pm):
    pose = 3.0, -2.0, 0.7
    path = arc_path(pose, Answer(curvature_1pm, 6.0))
    assert set(path[:, 2]) == {6.0}
    distances = np.hypot(*(path[:, :2] - pose[:2]).T)
    assert distances.min() == pytest.approx(0.0, abs=1e-9)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    rear = np.array(pose[:2]) - REAR_M * np.array([c, s])
    centre = rear + np.array([-s, c]) / curvature_1pm
    radius_m = math.hypot(1.0 / curvature_1pm, REAR_M)
    assert np.hypot(*(path[:, :2] - centre).T) == pytest.approx(radius_m, abs=1e-6)


def test_view_is_the_road_in_the_picture():
    picture = np.zeros((480, 640, 4), np.uint8)
    picture[:240] = 255
    picture[300:320, 100:200] = 200
    view = road_view(picture)
    assert view.shape == (40, 128, 3)
    assert (view[12:16, 20:40] == 200).all()
    assert view.sum() == 3 * 200 * 4 * 20
    with pytest.raises(ValueError, match="640 x 480 pixels, got 320 x 240"):
        road_view(picture[::2, ::2])
