"""The camera picture: positions of lines and objects, what hides what, independence of the past."""

import itertools

import cv2
import numpy as np
import pytest
from arcs import route

from sdc_sim.camera.boxes import Box
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.road import DASH_LENGTH_M, DASH_PERIOD_M, Road
from sdc_sim.road.road_markings import lane_points

pytestmark = pytest.mark.slow(12)

BLUE = (255, 0, 0)
STRAIGHT = Road([[0.0, 0.0], [400.0, 0.0]])
CURVY = Road(route(60, (40, 1.2), 30, (25, -1.6), 60, step_m=0.5))


def pose(road, s_m, left_m=0.0):
    """Return x, y and yaw at a distance along a road and to the left of it."""
    points, left = road.at(np.array([s_m]))
    x, y = points[0] + left_m * left[0]
    return float(x), float(y), float(np.arctan2(-left[0, 0], left[0, 1]))


class _Bare(Road):
    """A road without scenery, whose shadows would cover its lines."""

    def scenery(self, seed=0):
        found = super().scenery(seed)
        return selected(found, np.zeros(len(found), bool))


def selected(scenery, keep):
    names = "kind", "position_m", "yaw_rad", "size_m", "variant"
    return type(scenery)(*(getattr(scenery, name)[keep] for name in names))


@pytest.fixture(scope="module")
def straight():
    return Renderer(STRAIGHT)


@pytest.fixture(scope="module")
def curvy():
    return Renderer(CURVY)


# ------------------------------------------------------------------ geometry


def test_project_returns_pixels_computed_by_hand():
    cam = CameraModel()
    pitch = np.deg2rad(0.5)
    points = [[10.7, 0.0, 0.0], [10.7, -2.0, 1.7], [-5.0, 0.0, 0.0]]
    pixels, front = cam.project(points, 0.0, 0.0, 0.0)
    assert front.tolist() == [True, True, False]
    assert np.isnan(pixels[2]).all()
    assert pixels[0] == pytest.approx([320.0, 240.0 + 320.0 * np.tan(np.arctan(0.17) - pitch)])
    assert pixels[1, 0] == pytest.approx(320.0 + 320.0 * 2.0 / (10.0 * np.cos(pitch)))


# ------------------------------------------------------------------ lines


def _grey(picture):
    return picture[..., :3].astype(float).mean(axis=2)


def _line_errors(renderer, at, points, rows):
    """Return the distances of the painted line from the projected points (N, 2), by row [px]."""
    grey = _grey(renderer.render(*at))
    pixels, front = renderer.camera.project(np.column_stack([points, np.zeros(len(points))]), *at)
    pixels = pixels[front]
    pixels = pixels[np.argsort(pixels[:, 1])]
    errors = []
    for row in rows:
        if not pixels[0, 1] < row < pixels[-1, 1]:
            continue
        u = float(np.interp(row, pixels[:, 1], pixels[:, 0]))
        slope = abs(np.interp(row + 1, pixels[:, 1], pixels[:, 0]) - u)
        distance = renderer.camera.focal_px * 1.7 / (row - renderer.camera.horizon_px)
        half = int(np.ceil(1.0 + 0.5 * 0.15 * 320.0 / distance * np.hypot(1.0, slope / 3.0))) + 2
        middle = int(round(u))
        if middle - half < 0 or middle + half >= grey.shape[1]:
            continue
        window = grey[row, middle - half : middle + half + 1]
        ground, paint = np.percentile(window, [25, 95])
        assert paint - ground > 20.0, f"no line in row {row} near column {u:.0f}"
        # The limits exclude the grain of paint and roadway, and 0.55 the kerb.
        weight = np.clip(((window - ground) / (paint - ground) - 0.55) * 4.0 + 0.5, 0.0, 1.0)
        along_row = float(np.sum(weight * np.arange(-half, half + 1)) / weight.sum()) + middle - u
        errors.append(along_row / np.hypot(1.0, slope))
    return np.array(errors)


@pytest.mark.parametrize("offset", ["right_edge_m", "left_edge_m"])
@pytest.mark.parametrize(
    "s_m, aside_m, turn_rad", [(20.0, 0.4, 0.06), (90.0, 0.3, 0.05), (165.0, 0.0, 0.1)]
)
def test_solid_lines_are_where_the_geometry_puts_them(offset, s_m, aside_m, turn_rad):
    road = _Bare(route(60, (40, 1.2), 30, (25, -1.6), 60, step_m=0.5))
    x, y, yaw = pose(road, s_m, aside_m)
    points, seen = lane_points(road, getattr(road, offset), s_m + np.arange(2.5, 24.0, 0.1))
    errors = _line_errors(Renderer(road), (x, y, yaw + turn_rad), points[seen], range(262, 470, 4))
    assert len(errors) >= 10
    assert np.abs(errors).max() < 1.0
    assert abs(errors.mean()) < 0.3


def test_dashes_are_where_the_geometry_puts_them():
    road = _Bare([[0.0, 0.0], [400.0, 0.0]])
    renderer = Renderer(road)
    at = (100.0, 0.3, 0.03)
    first = DASH_PERIOD_M * np.ceil(103.0 / DASH_PERIOD_M)
    for start in (first, first + DASH_PERIOD_M):
        s_m = start + np.arange(0.2, DASH_LENGTH_M - 0.2, 0.05)
        points, _ = lane_points(road, road.centre_line_m, s_m)
        errors = _line_errors(renderer, at, points, range(255, 470))
        assert len(errors) >= 3
        assert np.abs(errors).max() < 1.0
        gap, _ = renderer.camera.project([[start + 6.0, road.centre_line_m, 0.0]], *at)
        u, v = np.round(gap[0]).astype(int)
        dash, _ = renderer.camera.project([[start + 1.5, road.centre_line_m, 0.0]], *at)
        du, dv = np.round(dash[0]).astype(int)
        grey = _grey(renderer.render(*at))
        assert grey[dv, du] > grey[v, u] + 50.0


@pytest.mark.parametrize("pitch_deg", [0.5, 0.0, 2.0])
def test_horizon_is_correct_to_one_pixel(pitch_deg):
    model = CameraModel(pitch_rad=np.deg2rad(pitch_deg))
    horizon = model.height / 2 - 320.0 * np.tan(np.deg2rad(pitch_deg))
    bare = Renderer(_Bare([[0.0, 0.0], [400.0, 0.0]]), model)
    picture = bare.render(0.0, 0.0, np.pi / 2).astype(float)
    step = np.abs(np.diff(picture[..., :3].mean(axis=1), axis=0)).sum(axis=1)
    near = slice(int(horizon) - 4, int(horizon) + 4)
    rows = np.arange(len(step))[near] + 0.5
    edge = rows[step[near] == step[near].max()].mean()
    assert abs(edge - horizon) <= 1.0


# ------------------------------------------------------------------ objects


def _covered(renderer, at, *boxes):
    return np.any(renderer.render(*at, boxes=boxes) != renderer.render(*at), axis=2)


@pytest.mark.parametrize(
    "kind, size",
    [("car", (4.7, 2.0, 1.45)), ("pedestrian", (0.5, 0.6, 1.8)), ("obstacle", (1.0, 1.0, 1.0))],
)
def test_a_box_fills_its_outline_in_the_picture(straight, kind, size):
    box = Box(20.0, 1.0, 0.0, *size, colour_bgr=(20, 20, 230), kind=kind)
    changed = _covered(straight, (0.0, 0.0, 0.0), box)
    signs = np.array([*itertools.product((-0.5, 0.5), (-0.5, 0.5), (0, 1))])
    corners = (20.0, 1.0, 0.0) + signs * size
    pixels, _ = straight.camera.project(corners, 0.0, 0.0, 0.0)
    rows, columns = np.nonzero(changed)
    assert rows.min() == pytest.approx(pixels[:, 1].min(), abs=2.5)
    assert columns.min() >= pixels[:, 0].min() - 1.5
    assert columns.min() == pytest.approx(pixels[:, 0].min(), abs=3.0)


@pytest.mark.parametrize(
    "far, near",
    [
        ((25.0, 0.0, 0.0, 1.0, 1.0, 1.0, BLUE, "obstacle"), (10.0, 0.0, 0.0, 1.0, 3.0, 2.5)),
        ((30.0, 0.0, 0.3, 4.7, 2.0, 1.45, BLUE, "car"), (9.0, 0.0, 0.0, 0.5, 5.0, 3.0)),
        # A long wall whose centre is farther away than the pedestrian that it hides.
        ((13.0, 3.0, 0.0, 0.5, 0.6, 1.7, BLUE, "pedestrian"), (18.0, 1.2, 0.0, 24.0, 0.4, 3.0)),
    ],
)
def test_a_near_box_hides_a_far_one_in_any_order(straight, far, near):
    at, far, near = (0.0, 0.0, 0.0), Box(*far), Box(*near, (0, 0, 255), "obstacle")
    alone = straight.render(*at, boxes=[near])
    both = straight.render(*at, boxes=[far, near])
    assert np.array_equal(both, straight.render(*at, boxes=[near, far]))
    face = np.all(np.abs(alone[..., :3].astype(int) - [0, 0, 200]) < [40, 40, 70], axis=2)
    assert face.sum() > 500
    inner = cv2.erode(face.astype(np.uint8), np.ones((7, 7), np.uint8)).astype(bool)
    assert inner.sum() > 500
    assert np.array_equal(both[inner], alone[inner])


def test_a_box_in_front_of_a_long_wall_is_visible(straight):
    wall = Box(18.0, 4.0, 0.0, 24.0, 0.4, 3.0, (0, 0, 255), "obstacle")
    walker = Box(20.0, 2.5, 0.0, 0.5, 0.6, 1.7, (255, 0, 0), "pedestrian")
    picture = straight.render(0.0, 0.0, 0.0, boxes=[walker, wall]).astype(int)
    assert np.sum((picture[..., 0] > 120) & (picture[..., 2] < 60)) > 40


def test_buildings_hide_boxes_behind_them(straight):
    scenery = straight.objects.scenery
    k = int(np.flatnonzero((scenery.kind == 2) & (scenery.position_m[:, 0] > 40.0))[0])
    middle, depth = scenery.position_m[k], scenery.size_m[k, 1]
    side = np.sign(middle[1])
    at = (float(middle[0]), 0.0, float(side * np.pi / 2))

    def red(sign):
        place = middle + (0.0, side * sign * (0.5 * depth + 3.0))
        box = Box(*place, 0.0, 2.0, 2.0, 1.0, (0, 0, 255), "obstacle")
        picture = straight.render(*at, boxes=[box])[..., :3].astype(int)
        return np.sum(np.all(np.abs(picture - [0, 0, 205]) < 55, axis=2))

    assert red(1.0) == 0 and red(-1.0) > 300


def test_the_lit_lamp_of_a_traffic_light_is_visible_from_its_front_only(straight):
    def red(yaw):
        light = Box(15.0, -3.0, yaw, 0.5, 0.5, 3.0, (0, 0, 255), "light")
        picture = straight.render(0.0, 0.0, 0.0, boxes=[light]).astype(int)
        return np.sum((picture[..., 2] > 200) & (picture[..., 1] < 60) & (picture[..., 0] < 60))

    assert red(np.pi) > 8 and red(0.0) == 0


# ------------------------------------------------------------------ the picture as a whole


def test_night_scales_the_brightness(curvy):
    at = pose(CURVY, 20.0)
    day, dusk, night = (curvy.render(*at, light=light) for light in (1.0, 0.5, 0.0))
    assert not night[..., :3].any() and np.all(night[..., 3] == 255)
    assert np.abs(dusk[..., :3] - 0.5 * day[..., :3]).max() <= 1.0
