"""Lidars measure the shapes that the camera draws, to within a millimetre."""

import math

import numpy as np
import pytest
from presets import TESLA

from sdc_sim.camera.buildings import building
from sdc_sim.camera.meshes import table_mesh
from sdc_sim.physics.obstacles import KINDS, ObstacleState
from sdc_sim.physics.traffic_lights import TrafficLightState
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.road.scenery import BLOCK, HOUSE, TREE, Scenery
from sdc_sim.sensors.lidar import Frusta, PlanarLidar, RoofLidar
from sdc_sim.sensors.model import Moment, SensorContext, sensor_settings

pytestmark = pytest.mark.slow(3)

MILLIMETRE = 1e-3
ELEVATIONS = np.radians(np.arange(-15.0, 16.0, 2.0))


def rows(*values):
    return [np.atleast_1d(np.asarray(value, float)) for value in values]


def box(x_m, y_m, yaw_rad, length_m, width_m, top_m, bottom_m=0.0):
    half = 0.5 * np.array([[length_m, length_m, width_m, width_m]])
    place = np.array([[x_m, y_m]]), *rows(yaw_rad)
    return Frusta(*place, half, np.zeros((1, 4)), *rows(bottom_m, top_m))


def scenery_of(kind, x_m, y_m, yaw_rad, size_m):
    return Scenery(*map(np.array, ([kind], [[x_m, y_m]], [yaw_rad], [size_m], [3])))


NOTHING = scenery_of(TREE, 1e6, 0.0, 0.0, (3.0, 3.0, 5.0))


def lidar(model, scenery=NOTHING, **settings):
    name = "lidar" if model is RoofLidar else "planar_lidar"
    values = sensor_settings(name, {"period_s": 0.1, "range_m": 80.0, **settings})
    return model(values, SensorContext(5, 3, 0.1, TESLA, None, lambda: scenery))


def test_level_beams_measure_a_wall():
    model = lidar(PlanarLidar, range_m=60.0)
    ranges = model.cast(1.0, 2.0, 0.3, [box(21.0, 2.0, 0.0, 20.0, 400.0, 5.0)])
    angles = np.arange(-540, 540) * 2.0 * np.pi / 1440 + 0.3
    with np.errstate(divide="ignore"):
        wall = 10.0 / np.cos(angles)
    wall[(np.cos(angles) <= 0.0) | (wall > 60.0)] = np.inf
    np.testing.assert_allclose(ranges[0], wall, atol=MILLIMETRE)


def test_rings_measure_ground_side_and_top_of_a_box():
    model = lidar(RoofLidar, range_m=100.0)
    ranges = model.cast(0.0, 0.0, 0.0, [box(12.0, 0.0, 0.0, 4.0, 2.0, 1.5)])
    ahead, back = ranges[:, 512], ranges[:, 0]
    ground = np.where(ELEVATIONS < 0.0, 2.4 / np.sin(np.maximum(-ELEVATIONS, 1e-9)), np.inf)
    ground[ground > 100.0] = np.inf
    np.testing.assert_allclose(back, ground, atol=MILLIMETRE)
    for elevation, measured, below in zip(ELEVATIONS, ahead, ground):
        side_z = 2.4 + 10.0 * math.tan(elevation)
        top = 0.9 / math.tan(-elevation) if elevation < 0.0 else math.inf
        if below * math.cos(elevation) < 10.0:
            expected = below
        elif side_z <= 1.5:
            expected = 10.0 / math.cos(elevation)
        else:
            expected = 0.9 / math.sin(-elevation) if 10.0 <= top <= 14.0 else below
        assert measured == pytest.approx(expected, abs=MILLIMETRE)
    # The beams meet the ground in front of the box, its side and its top.
    assert {round(float(one), 3) for one in ahead[:5]} > {round(10.0 / math.cos(ELEVATIONS[3]), 3)}


def distance_to_faces(points, polygons):
    """Return the distance of each point to the nearest plane of the polygons (F, n, 3) [m]."""
    normals = np.cross(polygons[:, 1] - polygons[:, 0], polygons[:, 2] - polygons[:, 1])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    offsets = np.einsum("pfk,fk->pf", points[:, None] - polygons[:, 0], normals)
    return np.abs(offsets).min(axis=1)


def points_above_ground(model, moment):
    points = model.read(moment, 0)[:, :3].astype(float)
    points[:, 2] += 2.4
    return points[points[:, 2] > 0.05]


@pytest.mark.parametrize(
    ("kind", "size", "least"), [(BLOCK, (16.0, 11.0, 13.2), 900), (HOUSE, (11.0, 8.0, 7.4), 200)]
)
def test_buildings_are_those_of_the_camera(kind, size, least):
    scenery = scenery_of(kind, 18.0, 9.0, 0.7, size)
    polygons = building(scenery, 0).polygons
    ranged = lidar(RoofLidar, scenery)
    for x_m, y_m in ((0.0, 0.0), (10.0, 28.0), (40.0, 9.0), (18.0, -8.0)):
        moment = Moment(0.0, VehicleState(x_m=x_m, y_m=y_m))
        points = points_above_ground(ranged, moment) + (x_m, y_m, 0.0)
        assert len(points) > least
        near = distance_to_faces(points, polygons)
        # The roof of the camera has no underside where it is wider than the house.
        assert (near < MILLIMETRE).mean() > (0.999 if kind == BLOCK else 0.85)


def test_car_and_pole_are_those_of_the_camera():
    obstacle = ObstacleState(101, "car", 9.0, 3.0, 0.8, *KINDS["car"].size_m, 0.0)
    light = TrafficLightState(1001, 6.0, -5.0, 0.3, 2)
    points = points_above_ground(
        lidar(RoofLidar), Moment(0.0, VehicleState(), (obstacle,), (light,))
    )
    car = points[points[:, 1] > 0.0]
    c, s = math.cos(0.8), math.sin(0.8)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    polygons = (table_mesh("car").corners * KINDS["car"].size_m) @ turn + (9.0, 3.0, 0.0)
    assert len(car) > 200
    assert distance_to_faces(car, polygons).max() < MILLIMETRE
    pole = points[points[:, 1] < 0.0]
    assert len(pole) > 20
    assert np.hypot(pole[:, 0] - 6.0, pole[:, 1] + 5.0).max() < 0.26


@pytest.mark.parametrize(
    ("z_m", "pitch_deg", "is_seen"),
    [(0.0, 0.0, True), (6.0, 0.0, False), (-6.0, 0.0, False), (3.0, -5.71, True)],
)
def test_what_is_on_another_level_is_not_seen(z_m, pitch_deg, is_seen):
    """On a slope, the level of the car is that of its plane."""
    car = ObstacleState(101, "car", 30.0, 3.0, 0.0, *KINDS["car"].size_m, 0.0, 10.0 + z_m)
    light = TrafficLightState(1001, 30.0, -5.0, 0.0, 2, 10.0 + z_m)
    slope = 10.0, math.radians(pitch_deg)
    moment = Moment(0.0, VehicleState(), (car,), (light,), *slope)
    assert bool(len(points_above_ground(lidar(RoofLidar), moment))) == is_seen


def test_trunk_and_crown_of_a_tree_are_visible():
    tree = scenery_of(TREE, 8.0, 0.0, 0.0, (6.0, 6.0, 8.0))
    ranges = lidar(PlanarLidar, tree).ranges(Moment(0.0, VehicleState()))
    width = np.isfinite(ranges).sum() * math.radians(0.25) * (8.0 - 2.35)
    assert width == pytest.approx(2.0 * 8.0 * 12.0 / 512.0, abs=0.03)
    points = points_above_ground(lidar(RoofLidar, tree), Moment(0.0, VehicleState()))
    assert points[:, 2].max() > 3.0
    assert np.hypot(points[:, 0] - 8.0, points[:, 1]).max() < 8.0 * 163.0 / 512.0 + MILLIMETRE


def test_errors_of_the_ranges_have_their_sizes():
    wall = scenery_of(BLOCK, 30.0, 0.0, 0.0, (20.0, 60.0, 9.0))
    moment = Moment(0.0, VehicleState())
    true = lidar(PlanarLidar, wall).read(moment, 0)
    assert true.dtype == np.float32
    ranges = np.linalg.norm(true[:, :3].astype(float), axis=1)
    np.testing.assert_allclose(true[:, 3], np.exp(-0.004 * ranges), atol=1e-6)

    def measured(tick, **settings):
        points = lidar(PlanarLidar, wall, **settings).read(moment, tick)
        return np.linalg.norm(points[:, :3].astype(float), axis=1)

    noisy = measured(1, noise_m=0.05)
    assert (noisy - ranges).std() == pytest.approx(0.05, rel=0.2)
    assert (measured(1, noise_m=0.05) == noisy).all()
    assert not (measured(2, noise_m=0.05) == noisy).any()
    assert np.ptp(measured(1, bias_m=0.3) - ranges) < 1e-4
    assert np.ptp(measured(1, scale=0.1) / ranges) < 1e-5
