"""The camera picture of a network: its areas, lines, crosswalks and scenery."""

import math

import cv2
import numpy as np
import pytest

from sdc_map.network import (
    BROKEN,
    KERB,
    SOLID,
    STOP,
    WALKING,
    Connection,
    Junction,
    Network,
    RoadLane,
)
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.ground_textures import GRASS_BGR
from sdc_sim.camera.network_rasterizer import NetworkRasterizer
from sdc_sim.camera.renderer import Renderer
from sdc_sim.camera.signs import sign
from sdc_sim.road.network_scenery import network_scenery
from sdc_sim.road.scenery import SIGN, STOP_SIGN, TREE, Scenery

pytestmark = pytest.mark.slow(3)


def lane(name, points, left_line, right_line, **more):
    return RoadLane(name, np.array(points, float), 3.5, 10.0, left_line, right_line, **more)


_WAYS = (
    Connection("a", ("x",), "c", "s", line=STOP),
    *(Connection("b", (), end, turn) for end, turn in (("c", "r"), ("d", "l"))),
)
# Two lanes side by side along x, a junction behind them, and a crosswalk at x = 30.
_STREET = Network(
    "street",
    [
        lane("a", [(0, 0), (50, 0)], BROKEN, KERB, successors=("x",), left="b"),
        lane("b", [(0, 3.5), (50, 3.5)], SOLID, BROKEN, right="a"),
        lane("x", [(50, 0), (70, 0)], "none", "none", junction="j"),
        lane("s", [(0, 9), (50, 9)], "none", KERB, kind=WALKING),
    ],
    [Junction("j", "priority", np.array([(50, -12), (70, -12), (70, 12), (50, 12)], float), _WAYS)],
    [np.array([(30, -2), (30, 6), (33, 6), (33, -2)], float)],
    bays=[np.array([(5, -1.75), (10, -1.75), (10, -4.25), (5, -4.25)], float)],
    bus_stops=[np.array([(20, -1.75), (28, -1.75), (28, 0), (20, 0)], float)],
)


def plane_of(network):
    """Return a function of the brightness at points, 0..255, from tiles of the finest level."""
    rasterizer = NetworkRasterizer(network)

    def at(x, y, level=0):
        size = 6.4 * 2**level
        corner = np.floor(np.array([x, y]) / size) * size
        weights = rasterizer.weights(level, corner, size)
        if weights is None:
            return None
        column, row = ((np.array([x, y]) - corner) / size * 256).astype(int)
        return int(weights[0][row, column]), int(weights[1][row, column])

    return at


@pytest.fixture(scope="module", name="plane")
def _plane():
    return plane_of(_STREET)


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ((20.0, 0.0), (102, 0)),  # asphalt
        ((20.0, 5.25), (255, 0)),  # the solid line on the left
        ((19.5, 1.75), (255, 0)),  # a dash, which begins at 18 m
        ((23.5, 1.75), (102, 0)),  # between two dashes
        ((20.0, -1.75), (102, 0)),  # a kerb is no paint
        ((20.0, -2.2), (168, 0)),  # the kerb
        ((20.0, -3.0), (56, 140)),  # the verge
        ((20.0, 9.0), (127, 0)),  # a pavement
        ((50.0, 0.5), (255, 0)),  # the stop line
        ((60.0, 9.0), (102, 0)),  # the area of the junction
        ((31.5, 0.5), (255, 0)),  # a stripe of the crosswalk
        ((31.5, 1.1), (102, 0)),  # between two stripes
        ((7.5, -3.0), (102, 0)),  # a parking bay
        ((10.0, -3.0), (255, 0)),  # its line
        ((22.0, -0.26), (255, 0)),  # the zigzag line of a bus stop
        ((42.0, 0.0), (255, 0)),  # the arrow of lane a
        ((44.0, 0.12), (255, 0)),  # its point
        ((44.0, 0.8), (102, 0)),  # beside it
    ],
)
def test_brightness_and_grass_of_a_place(plane, place, expected):
    assert plane(*place) == expected


def test_grass_has_no_weights(plane):
    assert plane(20.0, 60.0) is None


def test_dashes_follow_a_narrow_bend():
    angles = np.linspace(0.0, np.pi, 60)
    bend = lane("bend", 5.25 * np.column_stack([np.sin(angles), -np.cos(angles)]), BROKEN, KERB)
    at = plane_of(Network("bend", [bend]))
    for s in np.arange(0.5, 2.6, 0.25):  # along the first dash, near its outer edge
        assert at(3.53 * np.sin(s / 3.5), -3.53 * np.cos(s / 3.5))[0] > 180, s


@pytest.mark.parametrize("level", range(6))
def test_every_level_shows_the_street(plane, level):
    brightness, grass = plane(20.0, 0.0, level)
    assert brightness == pytest.approx(102, abs=12) and grass < 40


def test_scenery_is_beside_the_lanes():
    scenery = network_scenery(_STREET, 0)
    assert len(scenery) > 3
    assert np.array_equal(scenery.position_m, network_scenery(_STREET, 0).position_m)
    for x, y in scenery.position_m[scenery.kind != SIGN]:
        assert math.dist((min(max(x, 0.0), 70.0), 0.0), (x, y)) > 3.0


@pytest.mark.parametrize(("limit_kmh", "has_buildings"), [(50.0, True), (90.0, False)])
def test_no_building_is_near_a_motorway(limit_kmh, has_buildings):
    points = np.array([(0.0, 0.0), (900.0, 0.0)])
    lanes = RoadLane("m", points, 3.5, limit_kmh / 3.6), RoadLane("s", points + (0, 90), 3.5, 10.0)
    beside = network_scenery(Network("m", lanes), 0)
    built = np.abs(beside.position_m[beside.kind != TREE, 1])
    assert (built.min() < 40.0) == has_buildings
    assert ((built > 60.0) & (built < 120.0)).sum() > 5, "the street beside it has its own"


def test_signs_are_right_of_lanes_where_right_of_way_and_limits_change():
    fast = RoadLane("f", np.array([(70.0, 0), (120, 0)]), 3.5, 30.0, predecessors=("x",))
    lanes = [*_STREET.lanes.values(), fast]
    lanes[2] = lane("x", [(50, 0), (70, 0)], "none", "none", junction="j", predecessors=("a",))
    scenery = network_scenery(Network("town", lanes, _STREET.junctions.values()), 0)
    rows = scenery.kind == SIGN
    assert sorted(scenery.variant[rows].tolist()) == [STOP_SIGN, 108]
    assert scenery.position_m[rows].tolist() == [[49.0, -2.5], [74.0, -2.5]]
    # The plate faces the cars: it is red from there, and grey from behind.
    stop = int(np.flatnonzero(rows)[0])
    faces = sign(scenery, stop)
    assert faces.normals[2:4] @ (-1, 0, 0) == pytest.approx(1.0)
    # The pole is as bright as the grass behind it: the lane filter does not mark its sides.
    grey = np.array([0.114, 0.587, 0.299])
    assert faces.bgr[:2] @ grey == pytest.approx(GRASS_BGR @ grey, abs=10.0)
    reds = faces.bgr[(faces.bgr[:, 2] > 150) & (faces.bgr[:, 0] < 100)]
    assert len(reds) >= 3


@pytest.mark.parametrize("number", [*range(3), 30, 47, 85, 96, 120])
def test_every_sign_has_faces_on_its_plate(number):
    one = Scenery(*map(np.array, ([SIGN], [(0.0, 0.0)], [0.0], [(0.08, 0.65, 2.6)], [number])))
    faces = sign(one, 0)
    assert np.abs(faces.polygons[2:, :, 1]).max() <= 0.33 and faces.polygons[..., 2].max() <= 2.6


def test_picture_of_a_street_depends_on_the_pose_only():
    camera = CameraModel()
    first = Renderer(_STREET, camera).render(5.0, 0.0, 0.0)
    other = Renderer(_STREET, camera)
    other.render(40.0, 3.5, 2.0)
    assert np.array_equal(first, other.render(5.0, 0.0, 0.0))
    # The road is grey ahead of the car.
    assert np.ptp(cv2.mean(first[-60:, 280:360])[:3]) < 12
