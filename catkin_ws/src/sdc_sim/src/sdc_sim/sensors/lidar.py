"""Lidars of the vehicle: one with 16 rings on the roof, and a planar one at the front.

All beams of a column have one direction on the ground, and all beams of a ring have one slope. With
the distance on the ground as the length of a beam, a vertical wall is equally far away for each
ring, and a horizontal face for each column. So most work is done once for each column or ring.

For each body only the columns that can hit it are computed. The columns of all bodies of a kind lie
one after another in one array, which needs few calls of NumPy. The bodies have the shapes that the
camera draws, and each kind computes where the beams enter and leave its bodies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from typing import Any, NamedTuple, Sequence, Union

import numpy as np

from sdc_common.driving import other_level
from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import TrafficLightState
from sdc_sim.road.scenery import (
    CROWN_CENTRE_SHARE,
    CROWN_RADIUS_SHARE,
    EAVES_SHARE,
    HOUSE,
    ROOF_BELOW_EAVES_M,
    ROOF_BEYOND_EAVES_M,
    TREE,
    TRUNK_RADIUS_SHARE,
    Scenery,
    chosen,
)
from sdc_sim.sensors.model import (
    MOUNTS_M,
    PLANAR_BEAMS,
    PLANAR_STEP_RAD,
    Moment,
    SensorContext,
    SensorModel,
    SensorSettings,
    error_sizes,
)
from sdc_sim.yaml_document import packaged_config

FAR_M = 1e9
_TURN = 2.0 * np.pi


# Share of the light that is lost for each metre, as CARLA's default.
_LOSS_PER_M = 0.004
# Added to the number of the sensor for the noise of the beams.
_BEAM_STREAM = 128


class Rays(NamedTuple):
    """The beams that may hit bodies."""

    owner: np.ndarray  # number of the body of each beam (B,)
    dx: np.ndarray  # from the lidar to the origins of the bodies (N,) [m]
    dy: np.ndarray  # from the lidar to the origins of the bodies (N,) [m]
    east: np.ndarray  # direction of each beam (B,)
    north: np.ndarray  # direction of each beam (B,)
    slopes: np.ndarray  # slope of each ring (R, 1)
    height_m: float  # height of the lidar


@dataclass(frozen=True, eq=False)
class Frusta:
    """Bodies with four sides, a horizontal top and a horizontal bottom, one row each."""

    position_m: np.ndarray  # origin in the map (N, 2)
    yaw_rad: np.ndarray  # direction of the body's x axis in the map (N,)
    # Distances from the origin to the front, rear, left and right side at the bottom (N, 4).
    reach_m: np.ndarray
    lean: np.ndarray  # by how much these distances grow for each metre upwards (N, 4)
    bottom_m: np.ndarray  # height of the bottom (N,)
    top_m: np.ndarray  # height of the top (N,)

    @cached_property
    def _axis(self) -> tuple[np.ndarray, np.ndarray]:
        return np.cos(self.yaw_rad), np.sin(self.yaw_rad)

    @cached_property
    def radius_m(self) -> np.ndarray:
        """Distance (N,) from the origin within which the body is."""
        widest = np.maximum(
            self.reach_m, self.reach_m + self.lean * (self.top_m - self.bottom_m)[:, None]
        )
        return np.hypot(widest[:, :2].max(axis=1), widest[:, 2:].max(axis=1))

    def _offset(self, dx: np.ndarray, dy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the origins along and across their own axes, from the lidar."""
        c, s = self._axis
        return c * dx + s * dy, c * dy - s * dx

    def inside(self, rays: Rays) -> tuple[np.ndarray, np.ndarray]:
        """Return the distances on the ground at which beams enter and leave their bodies.

        Returns:
            arrays (B,) or (R, B) that do not consider bottom and top
        """
        owner = rays.owner
        c, s = (component[owner] for component in self._axis)
        ahead, aside = c * rays.east + s * rays.north, c * rays.north - s * rays.east
        along, across = self._offset(rays.dx, rays.dy)
        front, rear, left, right = self.reach_m.T
        if not self.lean.any():
            # A beam moves by (ahead, aside) for each metre, from (-along, -across).
            low, high = ((along - rear)[owner] / ahead, (along + front)[owner] / ahead)
            near, far = ((across - right)[owner] / aside, (across + left)[owner] / aside)
            enter = np.maximum(np.minimum(low, high), np.minimum(near, far))
            return enter, np.minimum(np.maximum(low, high), np.maximum(near, far))
        above_m = rays.height_m - self.bottom_m
        enter, leave = np.full(1, -FAR_M), np.full(1, FAR_M)
        for reach, lean, origin, speed in zip(
            (front, rear, left, right),
            self.lean.T,
            (along, -along, across, -across),
            (ahead, -ahead, aside, -aside),
        ):
            gap = (reach + origin + lean * above_m)[owner]
            speed = speed - lean[owner] * rays.slopes
            side = gap / speed
            enter = np.maximum(enter, np.where(speed < 0.0, side, -FAR_M))
            leave = np.minimum(leave, np.where(speed > 0.0, side, FAR_M))
            leave = np.where((speed == 0.0) & (gap < 0.0), -1.0, leave)
        return enter, leave


@dataclass(frozen=True, eq=False)
class Cylinders:
    """Upright cylinders: position_m (N, 2), radius_m (N,), bottom_m (N,), top_m (N,)."""

    position_m: np.ndarray
    radius_m: np.ndarray
    bottom_m: np.ndarray
    top_m: np.ndarray

    def inside(self, rays: Rays) -> tuple[np.ndarray, np.ndarray]:
        """Return where beams enter and leave; see Frusta.inside."""
        owner, dx, dy = rays.owner, rays.dx, rays.dy
        along = dx[owner] * rays.east + dy[owner] * rays.north
        half = np.sqrt(along * along + (self.radius_m**2 - dx * dx - dy * dy)[owner])
        return along - half, along + half


@dataclass(frozen=True, eq=False)
class Balls:
    """Balls: position_m (N, 2) and height_m (N,) of the centre, radius_m (N,)."""

    position_m: np.ndarray
    height_m: np.ndarray
    radius_m: np.ndarray

    bottom_m = top_m = None

    def inside(self, rays: Rays) -> tuple[np.ndarray, np.ndarray]:
        """Return where beams enter and leave; see Frusta.inside."""
        owner, dx, dy = rays.owner, rays.dx, rays.dy
        dz = self.height_m - rays.height_m
        along = dx[owner] * rays.east + dy[owner] * rays.north + rays.slopes * dz[owner]
        square = (dx * dx + dy * dy + dz * dz - self.radius_m**2)[owner]
        steep = 1.0 + rays.slopes * rays.slopes
        half = np.sqrt(along * along - steep * square)
        return (along - half) / steep, (along + half) / steep


Bodies = Union[Frusta, Cylinders, Balls]


def angles(bodies: Bodies, dx: np.ndarray, dy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the directions in the map between which each body is, seen from a lidar (N,) [rad].

    Their origins are at dx, dy (N,) from the lidar [m].
    """
    share = bodies.radius_m / np.sqrt(dx * dx + dy * dy)
    half = np.arcsin(np.minimum(share, 1.0))
    half[share >= 1.0] = np.pi
    middle = np.arctan2(dy, dx)
    return middle - half, middle + half


def scenery_bodies(scenery: Scenery) -> list[Bodies]:
    """Return walls, roofs, trunks and crowns; a roof is one body that ends at the gables."""
    length, width, height = scenery.size_m.T
    tree, house = scenery.kind == TREE, scenery.kind == HOUSE
    half = 0.5 * np.stack([length, length, width, width], axis=1)
    zero = np.zeros(len(scenery))
    place_m, yaw_rad = scenery.position_m, scenery.yaw_rad
    walls_top_m = np.where(house, EAVES_SHARE, 1.0) * height
    roof_m = half + (0.0, 0.0, ROOF_BEYOND_EAVES_M, ROOF_BEYOND_EAVES_M)
    bottom_m = EAVES_SHARE * height - ROOF_BELOW_EAVES_M
    lean = np.zeros_like(half)
    lean[:, 2:] = -roof_m[:, 2:] / (height - bottom_m)[:, None]
    centre_m = CROWN_CENTRE_SHARE * height
    return [
        chosen(Frusta(place_m, yaw_rad, half, np.zeros_like(half), zero, walls_top_m), ~tree),
        chosen(Frusta(place_m, yaw_rad, roof_m, lean, bottom_m, height), house),
        chosen(Cylinders(place_m, TRUNK_RADIUS_SHARE * height, zero, centre_m), tree),
        chosen(Balls(place_m, centre_m, CROWN_RADIUS_SHARE * height), tree),
    ]


@lru_cache(maxsize=None)
def _prisms(kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the solid parts of a mesh.

    Returns:
        distances of front, rear, left and right side at the bottom and at the top (2, P, 4), and
        heights of bottom and top (2, P), as config/meshes.yaml has them
    """
    rows = [row for row in packaged_config("meshes")[kind] if "prism" in row]
    rectangles = np.array([[row["prism"], row["top"]] for row in rows], float)
    # From x0, x1, y0, y1 to the distances.
    sides = rectangles[..., [1, 0, 3, 2]] * (1.0, -1.0, 1.0, -1.0)
    return sides.swapaxes(0, 1), np.array([row["z"] for row in rows], float).T


def moving_bodies(
    obstacles: Sequence[ObstacleState], lights: Sequence[TrafficLightState]
) -> list[Frusta]:
    """Return the solid parts of obstacles and traffic lights."""
    places = [(obstacle.kind, *obstacle[2:8]) for obstacle in obstacles]
    # The lamps face the cars, against the heading of the lane.
    places += [
        ("light", light.x_m, light.y_m, light.heading_rad + math.pi, 1.0, 1.0, 1.0)
        for light in lights
    ]
    parts = []
    for kind, x_m, y_m, yaw_rad, length_m, width_m, height_m in places:
        sides, heights = _prisms(kind)
        (reach, at_top), count = sides * (length_m, length_m, width_m, width_m), sides.shape[1]
        bottom_m, top_m = heights * height_m
        lean = (at_top - reach) / (top_m - bottom_m)[:, None]
        position_m = np.tile([x_m, y_m], (count, 1))
        parts.append((position_m, np.full(count, yaw_rad), reach, lean, bottom_m, top_m))
    frusta = Frusta(*map(np.concatenate, zip(*parts)))
    upright = ~frusta.lean.any(axis=1)
    return [chosen(frusta, rows) for rows in (upright, ~upright)]


def near(bodies: Bodies, x_m: float, y_m: float, reach_m: float) -> Bodies:
    """Return the bodies whose origins are nearer than this to a place in the map [m]."""
    offset = bodies.position_m - (x_m, y_m)
    return chosen(bodies, (offset * offset).sum(axis=1) < reach_m**2)


class LidarModel(SensorModel):
    """A lidar that takes all beams of a scan at once.

    Args:
        turn: number of columns in a full turn
        columns: number of columns of a scan, half of them to the left of straight ahead
        elevations_rad: angles of the rings above the horizon
        mount_m: place on the vehicle
    """

    def __init__(
        self,
        turn: int,
        columns: int,
        elevations_rad: np.ndarray,
        mount_m: tuple[float, float, float],
        settings: SensorSettings,
        context: SensorContext,
    ):
        super().__init__(context.errors([error_sizes(settings, unit="_m")._replace(noise=0.0)]))
        self._noise_m = settings.noise_m
        self._beam_errors = context._replace(number=context.number + _BEAM_STREAM).errors([])
        self._turn, self._columns, self._step_rad = turn, columns, _TURN / turn
        self._mount_m, self._range_m = mount_m, settings.range_m
        angles = (np.arange(columns) - columns // 2) * self._step_rad
        self._first_rad = angles[0]
        self._slopes = np.tan(elevations_rad)[:, None]
        # Length of a beam for each metre on the ground.
        self._stretch = np.hypot(1.0, self._slopes)
        # Two turns: the columns of a body need no wrapping.
        turns = np.arange(2 * turn) * self._step_rad
        self._cosines, self._sines = np.cos(turns), np.sin(turns)
        with np.errstate(divide="ignore"):
            ground = np.where(self._slopes < 0.0, -mount_m[2] / self._slopes, FAR_M)
        self._ground = np.repeat(ground, 2 * turn, axis=1)
        elevations = elevations_rad[:, None]
        self._directions = np.stack(
            np.broadcast_arrays(
                np.cos(elevations) * np.cos(angles),
                np.cos(elevations) * np.sin(angles),
                np.sin(elevations),
            ),
            axis=-1,
        ).reshape(-1, 3)
        assert context.scenery is not None
        scenery = context.scenery()
        self._scenery = scenery_bodies(scenery)
        # No body of the scenery reaches farther from its origin.
        largest_m = float(np.hypot(*scenery.size_m[:, :2].T).max(initial=0.0))
        self._reach_m = settings.range_m + 0.5 * largest_m + ROOF_BEYOND_EAVES_M

    def cast(self, x_m: float, y_m: float, yaw_rad: float, bodies: Sequence[Bodies]) -> np.ndarray:
        """Return the ranges (rings, columns) from a pose, infinite beyond that of the lidar [m]."""
        nearest = self._ground.copy()
        yaw_rad += self._first_rad
        with np.errstate(divide="ignore", invalid="ignore"):
            for group in bodies:
                if len(group.position_m):
                    self._cast_bodies(nearest, x_m, y_m, yaw_rad, group)
        ranges = np.minimum(nearest[:, : self._turn], nearest[:, self._turn :])
        ranges *= self._stretch
        ranges[ranges > self._range_m] = np.inf
        return ranges[:, : self._columns]

    def _cast_bodies(
        self, nearest: np.ndarray, x_m: float, y_m: float, yaw_rad: float, bodies: Bodies
    ) -> None:
        dx, dy = bodies.position_m[:, 0] - x_m, bodies.position_m[:, 1] - y_m
        low, high = angles(bodies, dx, dy)
        first = np.ceil((low - yaw_rad) / self._step_rad).astype(np.int64)
        last = np.floor((high - yaw_rad) / self._step_rad).astype(np.int64)
        count = np.minimum(last - first + 1, self._turn)
        first %= self._turn
        # Of each beam that may hit: its body and its column.
        owner = np.repeat(np.arange(len(first)), count)
        if not len(owner):
            return
        column = np.arange(len(owner)) + (first - np.cumsum(count) + count)[owner]
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        cosine, sine = self._cosines[column], self._sines[column]
        east, north = c * cosine - s * sine, s * cosine + c * sine
        rings, height_m = self._slopes, self._mount_m[2]
        enter, leave = bodies.inside(Rays(owner, dx, dy, east, north, rings, height_m))
        if bodies.bottom_m is not None and bodies.top_m is not None:
            bottom, top = bodies.bottom_m - height_m, bodies.top_m - height_m
            at_bottom, at_top = bottom[owner] / rings, top[owner] / rings
            enter = np.maximum(enter, np.minimum(at_bottom, at_top))
            leave = np.minimum(leave, np.maximum(at_bottom, at_top))
        # From inside, a body is not visible.
        hits = np.where((enter <= leave) & (enter > 0.0), enter, FAR_M)
        hits = hits.reshape(-1, len(owner))
        start = 0
        for from_column, length in zip(first.tolist(), count.tolist()):
            part = nearest[:, from_column : from_column + length]
            np.minimum(part, hits[:, start : start + length], out=part)
            start += length

    def ranges(self, moment: Moment) -> np.ndarray:
        """Return the true ranges (rings, columns), infinite where nothing is in range [m]."""
        state, ahead = moment.state, self._mount_m[0]
        x_m = state.x_m + ahead * math.cos(state.yaw_rad)
        y_m = state.y_m + ahead * math.sin(state.yaw_rad)
        bodies = [near(group, x_m, y_m, self._reach_m) for group in self._scenery]
        plane_at = moment.plane_at
        around: list[Any] = [
            [body for body in states if not other_level(body.z_m, plane_at(body.x_m, body.y_m))]
            for states in (moment.obstacles, moment.traffic_lights)
        ]
        if any(around):
            bodies += moving_bodies(*around)
        return self.cast(x_m, y_m, state.yaw_rad, bodies)

    def read(self, moment: Moment, tick: int) -> np.ndarray:
        """Return the points (N, 4) of all beams that hit: x, y, z [m] and intensity, float32."""
        ranges = self.ranges(moment).ravel()
        beams = np.flatnonzero(ranges < np.inf)
        found = ranges[beams]
        # The loss is that of the true range.
        intensity = np.exp(-_LOSS_PER_M * found)
        found = found * self.errors.factors[0] + self.errors.apply([0.0], tick)[0]
        if self._noise_m:
            noise = self._beam_errors.random(tick).standard_normal(len(ranges))
            found += self._noise_m * noise[beams]
        points = np.empty((len(beams), 4), np.float32)
        np.multiply(self._directions[beams], found[:, None], out=points[:, :3], casting="unsafe")
        points[:, 3] = intensity
        return points


RINGS_RAD = np.radians(np.arange(-15.0, 16.0, 2.0))
RoofLidar = partial(LidarModel, 1024, 1024, RINGS_RAD, MOUNTS_M["lidar"])
PlanarLidar = partial(
    LidarModel, round(_TURN / PLANAR_STEP_RAD), PLANAR_BEAMS, np.zeros(1), MOUNTS_M["planar_lidar"]
)
