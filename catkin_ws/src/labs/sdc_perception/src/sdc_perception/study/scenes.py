"""Random pictures of lights, cars and pedestrians, with the truth of what is visible in them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import cv2
import numpy as np

from sdc_sim.camera.air import Air
from sdc_sim.camera.boxes import Box, obstacle_box, traffic_light_box
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.painting import dim, footprint
from sdc_sim.camera.renderer import Renderer
from sdc_sim.camera.scene_objects import SceneObjects
from sdc_sim.physics.obstacles import ObstaclePlan, ObstacleState, SimulatedObstacle
from sdc_sim.physics.traffic_lights import COLOURS, OFF, TrafficLightPlan, light_states
from sdc_sim.road.random_routes import random_route
from sdc_sim.road.road import Road
from sdc_sim.road.scenery import Scenery
from sdc_sim.simulation.weather import Weather

FRAMES_A_ROUTE = 50
LIGHT = "light"
# A light whose lamps are turned away farther is for other drivers.
_FACING_COS = 0.5
# Least distance between two lights along the road.
_CROSSING_M = 15.0
# Least visible share of a lamp and of a body.
_VISIBLE = 0.6
_KINDS = ("car", "car", "pedestrian", "pedestrian", "obstacle")
# The lamps of a traffic light, as in sdc_sim.camera.meshes.
_LAMP_BELOW_M = 0.2  # centre of the highest lamp below the top
_LAMP_SPACING_M = 0.32
_LAMP_AHEAD_M = 0.145  # centre of a lamp ahead of the pole
NO_SCENERY = Scenery(
    np.zeros(0, int), np.zeros((0, 2)), np.zeros(0), np.zeros((0, 3)), np.zeros(0, int)
)


class TrueObject(NamedTuple):
    """A light or a body in the picture."""

    kind: str  # LIGHT, or the kind of the body
    depth_m: float  # distance ahead of the camera, of a pole or of a body's nearest corner [m]
    left: float  # leftmost column [px]
    right: float  # rightmost column [px]
    visible: bool  # whether a driver sees it; otherwise it is hidden in part, or turned away
    state: int = OFF  # RED, YELLOW or GREEN of a light
    pixel: Sequence[float] = ()  # the lit lamp of a light


class Scene(NamedTuple):
    """A picture and the truth."""

    picture: np.ndarray  # BGRA (480, 640, 4)
    objects: list[TrueObject]  # the lights and bodies in view

    def visible(self, lights: bool) -> list[TrueObject]:
        """Return the visible lights, or the visible bodies."""
        return [body for body in self.objects if body.visible and (body.kind == LIGHT) == lights]


class SceneMaker:
    """Random scenes on random routes."""

    def __init__(self, first_seed: int, parameters: dict[str, Any]):
        """Prepare routes of consecutive seeds; the parameters are those of config/sim.yaml."""
        self._seed = first_seed
        self._light = parameters.get("daylight", 1.0)
        self._weather = Weather(**parameters.get("weather", {}))
        self._camera = CameraModel()

    def scenes(self, count: int) -> Iterator[Scene]:
        """Return random scenes."""
        for number in range(count):
            if number % FRAMES_A_ROUTE == 0:
                seed = self._seed + number // FRAMES_A_ROUTE
                road = Road(random_route(seed)[0])
                renderer = Renderer(road, seed=seed, weather=self._weather)
                # Draws a box as it looks where nothing hides it.
                air = Air(self._weather, self._camera, seed)
                alone = SceneObjects(NO_SCENERY, self._camera, air, seed)
                random = np.random.RandomState(seed)
            yield self._scene(road, renderer, alone, random)

    def _scene(
        self, road: Road, renderer: Renderer, alone: SceneObjects, random: np.random.RandomState
    ) -> Scene:
        s_m = random.uniform(0.0, max(road.length_m - 60.0, 1.0))
        x, y, heading = place(road, s_m, random.uniform(-0.4, 0.4))
        view = x, y, heading + random.uniform(-0.06, 0.06)
        lights, ahead_m = [], 0.0
        for _ in range(random.choice(3, p=(0.3, 0.5, 0.2))):
            ahead_m = random.uniform(ahead_m + 2.0, ahead_m + 45.0)
            body_place = place(road, s_m + ahead_m, 0.0)
            ahead_m += _CROSSING_M
            phases = ((COLOURS[random.randint(3)], 1.0),)
            lights.append(light_states([TrafficLightPlan(*body_place, phases)], 0.0)[0])
        bodies: list[ObstacleState] = []
        for _ in range(random.randint(4)):
            kind = _KINDS[random.randint(len(_KINDS))]
            left = random.choice((0.0, 3.5)) if kind == "car" else random.uniform(-4.0, 7.0)
            body_place = place(
                road, s_m + random.uniform(6.0, 45.0), left + random.normal(0.0, 0.3)
            )
            turn = random.choice((0.0, math.pi, random.uniform(-math.pi, math.pi)))
            plan = ObstaclePlan.stationary(kind, body_place[0], body_place[1], body_place[2] + turn)
            body = SimulatedObstacle(1, plan).body
            if all(math.dist((body.x_m, body.y_m), (o.x_m, o.y_m)) > 4.0 for o in bodies):
                bodies.append(body)
        boxes = [*map(traffic_light_box, lights), *map(obstacle_box, bodies)]
        ground = np.empty((self._camera.height, self._camera.width, 4), np.uint8)
        renderer.draw_background(ground, *view)
        objects = renderer.objects
        picture = _drawn(objects, ground, view, boxes)
        seen = []
        for number, light in enumerate(lights):
            off = traffic_light_box(light._replace(state=OFF))
            unlit = _drawn(objects, ground, view, _replaced(boxes, number, [off]))
            whole = [_drawn(alone, ground, view, [box]) for box in (boxes[number], off)]
            share = _difference(picture, unlit).sum() / max(_difference(*whole).sum(), 1)
            seen.append(self._light_seen(light, view, share))
        for number in range(len(lights), len(boxes)):
            without = _drawn(objects, ground, view, _replaced(boxes, number, []))
            pictures = picture, without, _drawn(alone, ground, view, [boxes[number]]), ground
            seen.append(self._body_seen(boxes[number], view, pictures))
        dim(picture, self._light)
        return Scene(picture, [body for body in seen if body is not None])

    def _light_seen(
        self, light: Any, view: tuple[float, float, float], share: float
    ) -> TrueObject | None:
        """Return a light, of whose lit lamp a share is visible; None if it is not in view."""
        c, s = math.cos(light.heading_rad), math.sin(light.heading_rad)
        height = traffic_light_box(light).height_m
        z = height - _LAMP_BELOW_M - _LAMP_SPACING_M * light.state
        lamp = [light.x_m - _LAMP_AHEAD_M * c, light.y_m - _LAMP_AHEAD_M * s, z]
        pixels, front = self._camera.project(np.array([lamp]), *view)
        depth = _depth(light.x_m, light.y_m, view) - self._camera.mount_x_m
        if not front[0] or depth < 1.0:
            return None
        u, v = pixels[0]
        scale = self._camera.focal_px / depth
        inside = 0.3 * scale < u < self._camera.width - 0.3 * scale and v > 1.1 * scale
        # A lamp is round and seen at an angle.
        to_car = np.array([view[0] - lamp[0], view[1] - lamp[1]])
        facing = float(-(to_car @ (c, s)) / np.linalg.norm(to_car))
        visible = inside and share >= _VISIBLE and facing >= _FACING_COS
        return TrueObject(LIGHT, depth, u - scale, u + scale, visible, light.state, pixels[0])

    def _body_seen(
        self, box: Box, view: tuple[float, float, float], pictures: tuple[np.ndarray, ...]
    ) -> TrueObject | None:
        """Return a body by pictures with it, without it, and of it alone; None if not in view."""
        size, width = (box.length_m, box.width_m), self._camera.width
        corners = footprint((box.x_m, box.y_m), box.yaw_rad, size)
        depths = [_depth(x, y, view) - self._camera.mount_x_m for x, y in corners]
        if max(depths) < 0.5:
            return None
        if min(depths) < 0.5:
            return TrueObject(box.kind, min(depths), 0.0, float(width), False)
        points = [(x, y, z) for x, y in corners for z in (0.0, box.height_m)]
        columns = self._camera.project(np.array(points), *view)[0][:, 0]
        left, right = float(columns.min()), float(columns.max())
        if right < 0.0 or left > width - 1:
            return None
        low, high = max(0, math.floor(left)), min(width, math.ceil(right) + 1)
        shown, without, alone, nothing = (picture[:, low:high] for picture in pictures)
        pixels = [_difference(*pair) > 0 for pair in ((shown, without), (alone, nothing))]
        share = pixels[0].sum() / max(pixels[1].sum(), 1)
        visible = bool(share >= _VISIBLE and left >= 0.0 and right <= width - 1)
        return TrueObject(box.kind, min(depths), left, right, visible)


def place(road: Road, s_m: float, left_m: float) -> tuple[float, float, float]:
    """Return x, y and heading at a distance along a road and to the left of its lane's centre."""
    points, left = road.at(np.array([s_m]))
    x, y = points[0] + left_m * left[0]
    return float(x), float(y), math.atan2(-left[0, 0], left[0, 1])


def _depth(x_m: float, y_m: float, view: tuple[float, float, float]) -> float:
    return (x_m - view[0]) * math.cos(view[2]) + (y_m - view[1]) * math.sin(view[2])


def _replaced(boxes: list[Box], number: int, others: list[Box]) -> list[Box]:
    return [*boxes[:number], *others, *boxes[number + 1 :]]


def _drawn(
    objects: SceneObjects, ground: np.ndarray, view: tuple[float, float, float], boxes: list[Box]
) -> np.ndarray:
    picture = ground.copy()
    objects.draw(picture, view, boxes)
    return picture


def _difference(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return by how much the pixels (H, W) of two pictures differ in all colours together."""
    return cv2.absdiff(first, second)[..., :3].sum(axis=2, dtype=int)
