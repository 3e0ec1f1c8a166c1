"""Many cars at once in Gymnasium's interface, each alone on a road without obstacles."""

from __future__ import annotations

import math
import os
from typing import Any

import cv2
import gymnasium
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from sdc_common.geometry.road_line import road_route
from sdc_common.machine_code import compiled
from sdc_experiments.configuration import vehicle_preset
from sdc_experiments.fleet import VehicleFleet
from sdc_experiments.learning import observation as obs
from sdc_experiments.learning.environment import ACTIONS, VECTORS, SdcEnvironment
from sdc_experiments.learning.road_table import (
    CROSS_TRACK,
    HEADING,
    SEGMENT,
    RoadTable,
    S,
    find_places,
)
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.road import Road
from sdc_sim.scenario.drive_setup import RouteSource, drive_setup


class SdcVectorEnvironment(gymnasium.vector.VectorEnv):
    """N cars; a step takes and returns arrays with a row for each.

    Observations, actions, rewards, ends, the entries of info and, with the same seeds, the first
    routes are those of SdcEnvironment. A car whose drive has ended drives its route again.

    Args:
        num_envs: number of cars, N
        random_routes: drive random routes
        routes: number of random routes; car i drives route i modulo this number, and after a reset
            with a seed, they are others
        route: the route without random ones; see drive_setup
        friction: factor of the tyres' grip
        vehicle: name of a vehicle preset
        threads: number of threads that share the physics, None for one for each core
        autoreset_mode: when a car whose drive has ended starts again: in the next step, in the same
            one, or when `reset` is called with the option reset_mask
        render_mode: "rgb_array" or None
        picture_size: width and height of the pictures [px]

    Raises:
        ValueError: an argument is not valid
    """

    # How a drive has ended, in the order of the indices of `_ends`.
    STATUSES: tuple[str, ...] = ("", "completed", "off_road")

    def __init__(  # noqa: PLR0913  Gymnasium makes it by the names of the arguments
        self,
        num_envs: int = 1,
        random_routes: bool = False,
        routes: int = 32,
        route: RouteSource | None = None,
        friction: float = 1.0,
        vehicle: str = "tesla_model3",
        threads: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        picture_size: tuple[int, int] = (640, 480),
    ):
        for name, count in (("num_envs", num_envs), ("routes", routes), ("threads", threads)):
            if count is not None and count < 1:
                raise ValueError(f"{name} must be at least 1, got {count}")
        self._autoreset = AutoresetMode(autoreset_mode)
        self.metadata = {**SdcEnvironment.metadata, "autoreset_mode": self._autoreset}
        self.num_envs = num_envs
        self.render_mode = obs.checked_render_mode(render_mode)
        self.single_action_space, self.single_observation_space = ACTIONS, VECTORS
        self.action_space = batch_space(ACTIONS, num_envs)
        self.observation_space = batch_space(VECTORS, num_envs)
        self._camera = CameraModel(*picture_size)
        self._random_routes = random_routes
        self._route_count = min(routes, num_envs)
        self._all = np.ones(num_envs, bool)
        self._waypoints_m: list[np.ndarray] = []
        self._roads: np.ndarray
        self._places: np.ndarray
        self._table: RoadTable
        if not random_routes:
            self._set_roads([drive_setup(route=route).waypoints_m], self._all)
        parameters = vehicle_preset(vehicle)
        self._fleet = VehicleFleet(parameters, num_envs, friction, threads or os.cpu_count() or 1)
        self._find_places = compiled(find_places)
        self._observations = np.zeros((num_envs, len(obs.ENTRIES)), np.float32)
        self._observations[:, -len(obs.NO_OBSTACLE) :] = obs.NO_OBSTACLE
        self._elapsed_s, self._halted_s = np.zeros(num_envs), np.zeros(num_envs)
        self._ended = np.zeros(num_envs, bool)
        self._was_reset = False

    def _set_roads(self, waypoints_m: list[np.ndarray], cars: np.ndarray) -> None:
        """Give these routes to some cars (N,) bool; the others stay on theirs."""
        roads, places = np.arange(self.num_envs) % len(waypoints_m), None
        if not cars.all():
            roads = np.where(cars, roads + len(self._waypoints_m), self._roads)
            waypoints_m = self._waypoints_m + waypoints_m
            places = self._places
            places[SEGMENT] -= self._table.ends[self._roads, 0]
        used, self._roads = np.unique(roads, return_inverse=True)
        self._waypoints_m = [waypoints_m[road] for road in used]
        self._renderers: dict[int, Renderer] = {}
        self._table = RoadTable([road_route(points_m) for points_m in self._waypoints_m])
        if places is None:
            places = self._table.starts(self._roads)
        else:
            places[SEGMENT] += self._table.ends[self._roads, 0]
        self._places = places

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Place cars at rest at their starts.

        Args:
            seed: chooses the random routes, route i by seed + i or by entry i of a list; None keeps
                those that there are
            options: {"reset_mask": (N,) bool} places only these cars, and only they get new routes

        Raises:
            ValueError: the list of seeds or the mask has another length
        """
        self._check_reset(seed, options)
        first = seed[0] if isinstance(seed, list) else seed
        super().reset(seed=first)
        has_roads = hasattr(self, "_table")
        mask = (options or {}).get("reset_mask", self._all) if has_roads else self._all
        if self._random_routes and (first is not None or not has_roads):
            seeds = seed
            if not isinstance(seeds, list):
                seeds = [None if first is None else first + i for i in range(self._route_count)]
            generators = [seeding.np_random(number)[0] for number in seeds[: self._route_count]]
            self._set_roads([obs.random_route(generator) for generator in generators], mask)
        self._start(np.flatnonzero(mask))
        self._ended = self._ended & ~mask
        self._was_reset = True
        return self._observe(), self._info(np.zeros(self.num_envs, int))

    def _check_reset(self, seed: Any, options: dict[str, Any] | None) -> None:
        """Raise ValueError for a list of seeds or a mask of another length than N."""
        count, mask = self.num_envs, np.asarray((options or {}).get("reset_mask", self._all))
        if isinstance(seed, list) and len(seed) != count:
            raise ValueError(f"seed must be a number or a list of {count}, got {len(seed)} seeds")
        if mask.shape != (count,) or mask.dtype != bool:
            raise ValueError(f"reset_mask must be ({count},) bool, got {mask.shape} {mask.dtype}")

    def _start(self, cars: np.ndarray) -> None:
        """Place some cars at the starts of their routes."""
        roads = self._roads[cars]
        self._fleet.reset(cars, *self._table.start[roads].T)
        self._places[:, cars] = self._table.starts(roads)
        self._elapsed_s[cars] = self._halted_s[cars] = 0.0
        rows = self._table.rows_ahead(roads, self._places[S, cars])
        self._observations[cars, obs.ROAD_ENTRIES] = rows

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Drive all cars for a tick of 0.05 s.

        Raises:
            ValueError: the actions have another shape or are not finite, or there was no reset
        """
        return self.drive(obs.checked_action(actions, (self.num_envs, 2)))

    def drive(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Drive all cars for a tick by actions that are checked; see step."""
        pedals, steer = actions.T
        if not self._was_reset:
            raise ValueError("the first step is before the first reset; call reset()")
        if self._autoreset is AutoresetMode.DISABLED and self._ended.any():
            raise gymnasium.error.ResetNeeded(
                "the drives of some cars have ended; call reset(options={'reset_mask': ended})"
            )
        throttle, brake = np.maximum(pedals, 0.0), np.maximum(-pedals, 0.0)
        self._fleet.step(throttle, brake, np.ascontiguousarray(steer), obs.TICK_S)
        state, before = self._fleet.state, self._places
        places = self._places = np.empty_like(before)
        roads = self._table.segments, self._table.ends, self._roads
        positions_m = state["x_m"], state["y_m"]
        self._fleet.share(self._find_places, *roads, positions_m, before, places)
        self._elapsed_s += obs.TICK_S
        speed = state["speed_mps"]
        self._halted_s = np.where(speed > obs.STANDSTILL_MPS, 0.0, self._halted_s + obs.TICK_S)
        status = self._ends()
        terminated = status > 0
        tolerance = 0.5 * obs.TICK_S
        truncated = self._elapsed_s > self._table.longest_s[self._roads] - tolerance
        truncated |= self._halted_s > obs.MAX_STANDSTILL_S - tolerance
        truncated &= ~terminated
        rewards = self._rewards(before[S], speed)
        rewards += obs.COMPLETED_REWARD * (status == 1) + obs.FAILED_REWARD * (status > 1)
        info: dict[str, Any] = {}
        if self._autoreset is AutoresetMode.NEXT_STEP and self._ended.any():
            again = self._ended
            self._start(np.flatnonzero(again))
            rewards[again], status[again] = 0.0, 0
            terminated &= ~again
            truncated &= ~again
        self._ended = terminated | truncated
        if self._autoreset is AutoresetMode.SAME_STEP and self._ended.any():
            ended, seen = self._ended, self._observe()
            observations = np.full(self.num_envs, None)
            for car in np.flatnonzero(ended):
                observations[car] = seen[car]
            info = {"final_obs": observations, "final_info": self._info(status, ended)}
            info = {**info, **{"_" + name: ended for name in info}}
            self._start(np.flatnonzero(ended))
            status = np.where(ended, 0, status)
        return self._observe(), rewards, terminated, truncated, {**info, **self._info(status)}

    def _ends(self) -> np.ndarray:
        """Return how the drives have ended (N,): indices of STATUSES."""
        off_road = np.abs(self._places[CROSS_TRACK]) > obs.OFF_ROAD_M
        to_end_m = self._table.length_m[self._roads] - self._places[S]
        at_rest = self._fleet.state["speed_mps"] < obs.STANDSTILL_MPS
        return np.where(off_road, 2, (to_end_m < obs.FINISH_WITHIN_M) & at_rest)

    def _info(self, status: np.ndarray, cars: np.ndarray | None = None) -> dict[str, Any]:
        """Return the entries of info, and the same names after "_" for the cars that have them."""
        places = self._places
        info = {"status": np.array(self.STATUSES, object)[status], "completed": status == 1}
        info |= {"s_m": places[S].copy(), "cross_track_m": places[CROSS_TRACK].copy()}
        return {**info, **{"_" + name: self._all if cars is None else cars for name in info}}

    def _rewards(self, before_m: np.ndarray, speed: np.ndarray) -> np.ndarray:
        rows = self._table.rows_ahead(self._roads, self._places[S])
        self._observations[:, obs.ROAD_ENTRIES] = rows
        speeding = np.maximum(speed - rows[:, rows.shape[1] // 2], 0.0)
        return (
            (self._places[S] - before_m) / obs.FULL_PROGRESS_M
            - self._places[CROSS_TRACK] ** 2
            - obs.SPEEDING_WEIGHT * speeding**2
        )

    def _observe(self) -> np.ndarray:
        state, places, observations = self._fleet.state, self._places, self._observations
        error = state["yaw_rad"] - places[HEADING]
        observations[:, 0] = state["speed_mps"]
        observations[:, 1] = places[CROSS_TRACK]
        observations[:, 2] = (error + math.pi) % (2.0 * math.pi) - math.pi
        observations[:, 3] = state["yaw_rate_radps"]
        observations[:, 4] = state["steer"]
        return observations.copy()

    def render(self) -> tuple[np.ndarray, ...] | None:
        """Return the picture of each car's front camera (height, width, 3) RGB."""
        if self.render_mode is None:
            return None
        state = self._fleet.state
        pictures = []
        for car, road in enumerate(self._roads.tolist()):
            if road not in self._renderers:
                self._renderers[road] = Renderer(Road(self._waypoints_m[road]), self._camera)
            pose = (state[name][car] for name in ("x_m", "y_m", "yaw_rad"))
            picture = self._renderers[road].render(*pose)
            pictures.append(cv2.cvtColor(picture, cv2.COLOR_BGRA2RGB))
        return tuple(pictures)
