"""Markings in synthetic pictures of one line."""

import math

import cv2
import numpy as np
import pytest

from sdc_perception.ground_plane import GroundPlane, MountingPose
from sdc_perception.marking_search import MarkingSearch, SearchSettings, View
from sdc_sim.camera.camera_model import CameraModel

GROUND = GroundPlane(CameraModel().intrinsic_matrix(), MountingPose(0.7, 1.7, math.radians(0.5)))
SEARCH = MarkingSearch(GROUND, SearchSettings(0.12, 4.0, 0.7, 0.5, 0.8))
X = np.arange(4.0, 14.0)


def picture(y_m, width_m=0.15, paint=230, asphalt=85):
    """Return a picture of a line along x, drawn at eight times the size."""
    gray = np.full((480, 640), asphalt, np.uint8)
    corners = np.array(
        [
            (3.0, y_m - width_m / 2),
            (30.0, y_m - width_m / 2),
            (30.0, y_m + width_m / 2),
            (3.0, y_m + width_m / 2),
        ]
    )
    corners = np.round(16 * GROUND.pixels(corners)).astype(np.int32)
    cv2.fillConvexPoly(gray, corners, paint, cv2.LINE_AA, 4)
    return gray


def find(gray, predicted_y_m, gate_m=0.4, white=1.0, earlier=(), covered=()):
    points = np.column_stack([X, np.full(len(X), predicted_y_m)])
    left = np.tile([0.0, 1.0], (len(X), 1))
    views = [view(gray, white, covered), *(view(one, white).as_earlier() for one in earlier)]
    return SEARCH.find(views, points, left, np.full(len(X), gate_m))


def view(gray, white=1.0, covered=()):
    """Return a picture of a car that has not moved; a white of 0.5 is coloured."""
    dark = (white * gray).astype(np.uint8)
    return View.of(cv2.merge([dark, gray, gray, gray]), (0.0, 0.0, 0.0), covered)


@pytest.mark.parametrize("error", [-0.3, -0.1, 0.0, 0.25])
def test_line_is_found_next_to_its_prediction(error):
    markings, inside = find(picture(-1.0), -1.0 - error)
    assert inside.sum() == len(X)
    assert len(markings.row) == len(X)
    assert markings.offset_m == pytest.approx(np.full(len(X), error), abs=0.03)


def test_edge_of_a_shadow_is_no_marking():
    gray = picture(-1.0, paint=85)
    gray[:, :250] = 45
    assert len(find(gray, -1.0)[0].row) == 0


@pytest.mark.parametrize(
    ("line", "white"), [({"width_m": 0.6}, 1.0), ({"paint": 40}, 1.0), ({}, 0.5)]
)
def test_wide_dark_or_coloured_line_is_no_marking(line, white):
    assert len(find(picture(-1.0, **line), -1.0, white=white)[0].row) == 0


@pytest.mark.parametrize("beyond_m, found", [(-1.12, 0), (-1.55, len(X))])
def test_line_next_to_grass_is_a_kerb(beyond_m, found):
    y = GROUND.points(np.stack(np.meshgrid(np.arange(640.0), np.arange(480.0)), axis=-1))[..., 1]
    white = np.where(y < beyond_m, 0.8, 1.0)
    assert len(find(picture(-1.0), -1.0, white=white)[0].row) == found


def test_streak_that_an_earlier_picture_does_not_show_is_no_marking():
    road, streak = picture(-1.0, paint=85), picture(-1.0)
    assert len(find(streak, -1.0)[0].row) == len(X)
    assert len(find(streak, -1.0, earlier=[road])[0].row) == 0
    assert len(find(streak, -1.0, earlier=[streak])[0].row) == len(X)


def test_line_outside_the_gate_is_not_found():
    assert len(find(picture(-1.0), -0.2, gate_m=0.12)[0].row) == 0


def test_profiles_outside_the_picture_are_not_searched():
    _, inside = find(picture(-1.0), -30.0)
    assert not inside.any()


def test_nothing_on_a_body_is_a_marking():
    u, v = GROUND.pixels(np.array([[8.0, -1.0]]))[0].round().astype(int)
    markings, inside = find(picture(-1.0), -0.7, covered=[(u - 40, v - 4, u + 40, v + 4)])
    assert inside.sum() == len(X) - 1
    assert len(markings.row) == len(X) - 1
    assert X[~inside].tolist() == [8.0]
