import math
from types import SimpleNamespace

import numpy as np
import pytest

from sdc_localization.landmarks import LandmarkMap
from sdc_localization.localizer import Localizer
from sdc_localization.scan_features import find_features, scan_points

LANE = np.column_stack([np.zeros(101), np.arange(0.0, 101.0)])
ANGLES = np.radians(np.arange(-135.0, 135.0, 0.25))


def scan(poles, walls=(), radius=0.17):
    """Return the points at which beams meet round poles and straight walls."""
    found = []
    for angle in ANGLES:
        direction, ranges = np.array([math.cos(angle), math.sin(angle)]), []
        for pole in poles:
            along = direction @ pole
            hidden = radius**2 - pole @ pole + along**2
            if along > 0.0 and hidden > 0.0:
                ranges.append(along - math.sqrt(hidden))
        for start, end in walls:
            wall = end - start
            matrix = np.column_stack([direction, -wall])
            if abs(np.linalg.det(matrix)) > 1e-9:
                distance, share = np.linalg.solve(matrix, start)
                if distance > 0.0 and 0.0 <= share <= 1.0:
                    ranges.append(distance)
        if ranges:
            found.append(min(ranges) * direction)
    return np.array(found).reshape(-1, 2)


def test_poles_are_found_at_their_centres():
    poles = np.array([[8.0, 3.0], [12.0, -6.0], [5.0, -4.0]])
    found = find_features(scan(poles), 0.17)
    assert len(found) == 3
    for pole in poles:
        assert np.hypot(*(found - pole).T).min() < 0.03


def test_corner_of_a_building_is_found_and_its_far_ends_are_not():
    corner = np.array([8.0, 5.0])
    ends = corner + (12.0, 3.0), corner + (-2.5, 10.0)
    found = find_features(scan([], [(corner, end) for end in ends]), 0.17)
    assert found == pytest.approx(corner[None, :], abs=0.02)


def test_wall_and_hidden_pole_are_no_landmarks():
    wall = np.array([4.0, -6.0]), np.array([4.0, 6.0])
    half_hidden = np.array([[8.0, 2.0]])
    screen = np.array([4.0, 1.0]), np.array([4.0, 0.05])
    assert len(find_features(scan([], [wall]), 0.17)) == 0
    assert len(find_features(scan(half_hidden, [screen]), 0.17)) <= 1
    assert len(find_features(np.zeros((0, 2)), 0.17)) == 0


def test_landmarks_correct_position_and_heading(settings):
    """The car is at (0, 10) and points north; it believes in another place and heading."""
    localizer = Localizer(settings)
    localizer.start(0.0, 10.0, 1.0, LANE)
    localizer.state[:3] += (0.15, 0.4, 0.03)
    landmarks = np.array([[4.0, 18.0], [-5.0, 25.0], [6.0, 30.0], [-4.0, 14.0]])
    known = LandmarkMap(landmarks, 0.05, 0.005, settings.gate_2)
    detections = np.column_stack([landmarks[:, 1] - 10.0, -landmarks[:, 0]])
    for _ in range(3):
        assert known.correct(localizer, detections) == 4
    assert localizer.state[:3] == pytest.approx((0.0, 10.0, 0.5 * math.pi), abs=0.02)


def test_detection_that_is_not_in_the_map_is_ignored(settings):
    localizer = Localizer(settings)
    localizer.start(0.0, 10.0, 0.01, LANE)
    before = localizer.state.copy()
    known = LandmarkMap(np.array([[4.0, 18.0]]), 0.05, 0.005, settings.gate_2)
    assert known.correct(localizer, np.array([[12.0, 7.0], [8.0, -6.0]])) == 0
    assert (localizer.state == before).all()


def cloud(points, **changes):
    fields = [SimpleNamespace(name=name, offset=4 * i, datatype=7) for i, name in enumerate("xyz")]
    rows = np.zeros((len(points), 4), np.float32)
    rows[:, :2] = points
    return SimpleNamespace(
        **{"fields": fields, "point_step": 16, "data": rows.tobytes(), **changes}
    )


def test_scan_without_x_and_y_is_refused():
    with pytest.raises(ValueError, match="not x and y"):
        scan_points(cloud([[1.0, 2.0]], fields=[]))
    with pytest.raises(ValueError):
        scan_points(cloud([[1.0, 2.0]], data=b"123"))
