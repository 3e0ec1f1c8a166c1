"""Many cars at once in Gymnasium's interface, each alone on a road without obstacles."""

from __future__ import annotations

import math
import os
from typing import Any, Mapping

import gymnasium
import numpy as np
from gymnasium.vector.utils import batch_space

from sdc_common.geometry.road_line import road_route
from sdc_experiments.configuration import vehicle_preset
from sdc_experiments.learning.environment import ACTIONS, VECTORS
from sdc_experiments.learning.observation import (
    COMPLETED_REWARD,
    ENTRIES,
    FAILED_REWARD,
    FINISH_WITHIN_M,
    FULL_PROGRESS_M,
    MAX_STANDSTILL_S,
    NO_OBSTACLE,
    OFF_ROAD_M,
    ROAD_ENTRIES,
    SPEEDING_WEIGHT,
    STANDSTILL_MPS,
    TICK_S,
    random_route,
)
from sdc_experiments.learning.road_table import RoadPlaces, RoadTable
from sdc_sim.physics.fleet import VehicleFleet
from sdc_sim.scenario.drive_setup import RouteSource, drive_setup

_NO_OPTIONS: Mapping[str, Any] = {}


class SdcVectorEnvironment(gymnasium.vector.VectorEnv):
    """N cars; a step takes and returns arrays with a row for each.

    Observations, actions, rewards and ends are those of SdcEnvironment. A car whose drive has
    ended is at the start of its next drive after the next step (AutoresetMode.NEXT_STEP).

    Args:
        num_envs: number of cars, N
        random_routes: drive random routes
        routes: number of random routes; car i drives route i modulo this number, and after a reset
            with a seed, they are others
        route: the route without random ones; see drive_setup
        friction: factor of the tyres' grip
        vehicle: name of a vehicle preset
        threads: number of threads that share the physics, None for one for each core
    """

    metadata = {"autoreset_mode": gymnasium.vector.AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        random_routes: bool = False,
        routes: int = 32,
        route: RouteSource | None = None,
        friction: float = 1.0,
        vehicle: str = "tesla_model3",
        threads: int | None = None,
    ):
        self.num_envs = num_envs
        self.single_action_space, self.single_observation_space = ACTIONS, VECTORS
        self.action_space = batch_space(ACTIONS, num_envs)
        self.observation_space = batch_space(VECTORS, num_envs)
        self._random_routes = random_routes
        self._route_count = routes
        if not random_routes:
            self._set_roads(RoadTable([drive_setup(route=route).route]))
        parameters = vehicle_preset(vehicle)
        self._fleet = VehicleFleet(parameters, num_envs, friction, threads or os.cpu_count() or 1)
        self._observations = np.zeros((num_envs, len(ENTRIES)), np.float32)
        self._observations[:, -len(NO_OBSTACLE) :] = NO_OBSTACLE

    def _set_roads(self, table: RoadTable) -> None:
        self._table = table
        self._roads = np.arange(self.num_envs) % len(table.length_m)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Place all cars at rest at their starts; a seed (the first of a list) chooses the routes.

        Args:
            seed: chooses the random routes; None keeps those that there are
            options: not used
        """
        first = seed[0] if isinstance(seed, list) else seed
        super().reset(seed=first)
        if self._random_routes and (first is not None or not hasattr(self, "_table")):
            routes = [road_route(random_route(self.np_random)) for _ in range(self._route_count)]
            self._set_roads(RoadTable(routes))
        everything = np.arange(self.num_envs)
        self._places = self._table.starts(self._roads)
        self._elapsed_s, self._halted_s = np.zeros(self.num_envs), np.zeros(self.num_envs)
        self._ended = np.zeros(self.num_envs, bool)
        self._start(everything)
        return self._observe(), {}

    def _start(self, cars: np.ndarray) -> None:
        """Place some cars at the starts of their routes."""
        roads = self._roads[cars]
        self._fleet.reset(cars, *self._table.start[roads].T)
        for values, start in zip(self._places, self._table.starts(roads)):
            values[cars] = start
        self._elapsed_s[cars] = self._halted_s[cars] = 0.0

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Drive all cars for a tick of 0.05 s."""
        pedals, steer = np.asarray(actions, float).T
        self._fleet.step(
            np.maximum(pedals, 0.0), np.maximum(-pedals, 0.0), np.ascontiguousarray(steer), TICK_S
        )
        state, before = self._fleet.state, self._places
        places = self._places = self._table.places(
            self._roads, before.segment, state["x_m"], state["y_m"]
        )
        self._elapsed_s += TICK_S
        speed = state["speed_mps"]
        self._halted_s = np.where(speed > STANDSTILL_MPS, 0.0, self._halted_s + TICK_S)
        off_road = np.abs(places.cross_track_m) > OFF_ROAD_M
        to_end_m = self._table.length_m[self._roads] - places.s_m
        completed = (to_end_m < FINISH_WITHIN_M) & (speed < STANDSTILL_MPS) & ~off_road
        terminated = off_road | completed
        tolerance = 0.5 * TICK_S
        truncated = self._elapsed_s > self._table.longest_s[self._roads] - tolerance
        truncated |= self._halted_s > MAX_STANDSTILL_S - tolerance
        truncated &= ~terminated
        rewards = self._rewards(places, before.s_m, speed)
        rewards += COMPLETED_REWARD * completed + FAILED_REWARD * off_road
        return self._finish(rewards, terminated, truncated, completed)

    def _rewards(self, places: RoadPlaces, before_m: np.ndarray, speed: np.ndarray) -> np.ndarray:
        rows = self._table.rows_ahead(self._roads, places.s_m)
        self._observations[:, ROAD_ENTRIES] = rows
        speeding = np.maximum(speed - rows[:, rows.shape[1] // 2], 0.0)
        return (
            (places.s_m - before_m) / FULL_PROGRESS_M
            - places.cross_track_m**2
            - SPEEDING_WEIGHT * speeding**2
        )

    def _finish(
        self,
        rewards: np.ndarray,
        terminated: np.ndarray,
        truncated: np.ndarray,
        completed: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Start the cars again whose drives ended in the last step, and return the step."""
        again = np.flatnonzero(self._ended)
        if len(again):
            self._start(again)
            rewards[again] = 0.0
            for flags in (terminated, truncated, completed):
                flags[again] = False
            self._observations[again, ROAD_ENTRIES] = self._table.rows_ahead(
                self._roads[again], self._places.s_m[again]
            )
        self._ended = terminated | truncated
        info = {
            "completed": completed,
            "s_m": self._places.s_m,
            "cross_track_m": self._places.cross_track_m,
        }
        return self._observe(rows_are_set=True), rewards, terminated, truncated, info

    def _observe(self, rows_are_set: bool = False) -> np.ndarray:
        state, places, observations = self._fleet.state, self._places, self._observations
        error = state["yaw_rad"] - places.heading_rad
        observations[:, 0] = state["speed_mps"]
        observations[:, 1] = places.cross_track_m
        observations[:, 2] = (error + math.pi) % (2.0 * math.pi) - math.pi
        observations[:, 3] = state["yaw_rate_radps"]
        observations[:, 4] = state["steer"]
        if not rows_are_set:
            observations[:, ROAD_ENTRIES] = self._table.rows_ahead(self._roads, places.s_m)
        return observations.copy()
