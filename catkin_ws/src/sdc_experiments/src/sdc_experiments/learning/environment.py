"""One car in Gymnasium's interface, with obstacles, traffic lights, disturbances and pictures."""

from __future__ import annotations

from typing import Any, Mapping, Sequence

import cv2
import gymnasium
import numpy as np

from sdc_common.driving import Command
from sdc_common.geometry.angles import wrap_angle
from sdc_common.geometry.polyline import Place
from sdc_experiments.learning import observation as obs
from sdc_sim.camera.boxes import obstacle_box, traffic_light_box
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.renderer import Renderer
from sdc_sim.physics.traffic_lights import RED, YELLOW
from sdc_sim.road.road import Road
from sdc_sim.scenario.drive_setup import DriveSetup, RouteSource, drive_setup
from sdc_sim.simulation.snapshot import Snapshot

OBSERVATIONS = ("vector", "camera")
_BACK_M, _AHEAD_M = 2.0, 4.0
_NO_OPTIONS: Mapping[str, Any] = {}
ACTIONS = gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32)
VECTORS = gymnasium.spaces.Box(
    np.array([low for _, low, _ in obs.ENTRIES], np.float32),
    np.array([high for _, _, high in obs.ENTRIES], np.float32),
)


class SdcEnvironment(gymnasium.Env):
    """A drive along a route.

    The action is (pedals, steer): positive pedals are throttle, negative ones brake; positive steer
    turns right. `observation.ENTRIES` names the entries of an observation.

    Args:
        scenario: name or path of a scenario, "" for the route alone
        route: the route, in place of that of the scenario; see drive_setup
        random_routes: drive another random route after each reset
        map: a map on which each reset draws the route, or the place of a `street_scenario`
        observation: "vector", or "camera" for an RGB picture
        picture_size: width and height of the pictures [px]
        sim_options: parameters that replace those of sdc_sim/config/sim.yaml
        render_mode: "rgb_array" or None; with gymnasium.make also "human", a window

    Raises:
        ValueError: an argument is not valid
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": round(1.0 / obs.TICK_S)}

    def __init__(
        self,
        scenario: str = "",
        route: RouteSource | None = None,
        random_routes: bool = False,
        map: str = "",  # noqa: A002  the name of the argument of ./drive
        observation: str = "vector",
        picture_size: tuple[int, int] = (640, 480),
        sim_options: Mapping[str, Any] = _NO_OPTIONS,
        render_mode: str | None = None,
    ):
        if observation not in OBSERVATIONS:
            raise ValueError(
                f"observation must be one of {', '.join(OBSERVATIONS)}, got {observation!r}"
            )
        self.render_mode = obs.checked_render_mode(render_mode)
        self.action_space = ACTIONS
        self._camera = CameraModel(*picture_size)
        self._shows_picture = observation == "camera"
        pictures = gymnasium.spaces.Box(0, 255, (picture_size[1], picture_size[0], 3), np.uint8)
        self.observation_space = pictures if self._shows_picture else VECTORS
        self._random_routes = random_routes
        self._map = map
        self._options = dict(sim_options)
        self._seed = self._options.pop("seed", None)
        if not random_routes and not map:
            self._use(drive_setup(scenario, route, sim_options))

    def _use(self, setup: DriveSetup) -> None:
        """Drive on another road."""
        self._setup = setup
        self._route = setup.route
        self._rows = obs.road_rows(setup.route).tolist()
        self._longest_s = obs.longest_s(setup.route)
        self._renderer: Renderer | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Place the car at rest at its start; the seed decides about routes and noise."""
        super().reset(seed=seed)
        if self._random_routes:
            self._use(drive_setup(route=obs.random_route(self.np_random), options=self._options))
        drawn = int(self.np_random.integers(2**32)) if self._seed is None else self._seed
        if self._map:
            options = {**self._options, "seed": drawn}
            self._use(drive_setup(options=options, map=self._map))
        self._setup.parameters["seed"] = drawn
        self._simulation = self._setup.simulation(compiled=True)
        observation = self._simulation.snapshot
        measured = observation.measured
        self._place = self._route.locate(measured.x_m, measured.y_m, measured.yaw_rad)
        self._moved_s = 0.0
        return self._observe(observation), self._info("")

    def step(
        self, action: np.ndarray | Sequence[float]
    ) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Drive for a tick of 0.05 s.

        Raises:
            ValueError: the action has another shape or is not finite, or there was no reset
        """
        pedals, steer = obs.checked_action(action, (2,)).tolist()
        if not hasattr(self, "_simulation"):
            raise ValueError("the first step is before the first reset; call reset()")
        braking = pedals < 0.0
        command = Command(0.0 if braking else pedals, steer, -pedals if braking else 0.0)
        simulation = self._simulation
        simulation.step(command)
        observation = simulation.snapshot
        state, before_m = observation.state, self._place.s_m
        place = self._place = self._route.line.project(
            state.x_m, state.y_m, before_m, _BACK_M, _AHEAD_M
        )
        limit = self._rows[round(place.s_m)][len(self._rows[0]) // 2]
        speeding = max(state.speed_mps - limit, 0.0)
        reward = (
            (place.s_m - before_m) / obs.FULL_PROGRESS_M
            - place.cross_track_m**2
            - obs.SPEEDING_WEIGHT * speeding * speeding
        )
        status = self._status(observation, place)
        if status:
            reward += obs.COMPLETED_REWARD if status == "completed" else obs.FAILED_REWARD
        if state.speed_mps > obs.STANDSTILL_MPS:
            self._moved_s = simulation.elapsed_s
        truncated = not status and (
            simulation.elapsed_s >= self._longest_s
            or simulation.elapsed_s - self._moved_s >= obs.MAX_STANDSTILL_S
        )
        return self._observe(observation), reward, bool(status), truncated, self._info(status)

    def _status(self, observation: Snapshot, place: Place) -> str:
        """Return how the drive has ended, "" while it lasts."""
        if observation.collisions:
            return "collision"
        if abs(place.cross_track_m) > obs.OFF_ROAD_M:
            return "off_road"
        to_end_m = self._route.length_m - place.s_m
        if to_end_m < obs.FINISH_WITHIN_M and observation.state.speed_mps < obs.STANDSTILL_MPS:
            return "completed"
        return ""

    def _info(self, status: str) -> dict[str, Any]:
        place = self._place
        return {"status": status, "s_m": place.s_m, "cross_track_m": place.cross_track_m}

    def _observe(self, observation: Snapshot) -> np.ndarray:
        if self._shows_picture:
            return self._picture(observation)
        state, place = observation.measured, self._place
        if state is not observation.state:
            place = self._route.line.project(state.x_m, state.y_m, place.s_m, _BACK_M, _AHEAD_M)
        values = [
            state.speed_mps,
            place.cross_track_m,
            wrap_angle(state.yaw_rad - place.heading_rad),
            state.yaw_rate_radps,
            state.steer,
            *self._rows[round(place.s_m)],
            *self._obstacle_ahead(observation, place.s_m),
        ]
        return np.array(values, np.float32)

    def _obstacle_ahead(self, observation: Snapshot, s_m: float) -> tuple[float, float, float]:
        """Return distance, offset and speed of the nearest obstacle or stop line before a light."""
        front_m = 0.5 * self._simulation.vehicle.parameters.length_m
        nearest = obs.NO_OBSTACLE
        for obstacle in observation.obstacles:
            place = self._route.line.project(obstacle.x_m, obstacle.y_m, s_m, 0.0, obs.HORIZON_M)
            ahead_m = place.s_m - s_m - front_m - 0.5 * obstacle.length_m
            is_ahead = place.s_m > s_m and ahead_m < nearest[0]
            if is_ahead and abs(place.cross_track_m) < obs.OFF_ROAD_M:
                nearest = ahead_m, place.cross_track_m, obstacle.speed_mps
        for plan, light in zip(self._simulation.lights, observation.traffic_lights):
            place = self._route.line.project(plan.x_m, plan.y_m, s_m, 0.0, obs.HORIZON_M)
            ahead_m = place.s_m - s_m - front_m
            if light.state in (RED, YELLOW) and place.s_m > s_m and 0.0 < ahead_m < nearest[0]:
                nearest = ahead_m, 0.0, 0.0
        return nearest

    def render(self) -> np.ndarray | None:
        """Return the picture of the front camera (height, width, 3) RGB."""
        if self.render_mode is None:
            return None
        return self._picture(self._simulation.snapshot)

    def _picture(self, observation: Snapshot) -> np.ndarray:
        if self._renderer is None:
            self._renderer = Renderer(Road(self._setup.waypoints_m), self._camera)
        state, boxes = observation.state, [*map(obstacle_box, observation.obstacles)]
        boxes += map(traffic_light_box, observation.traffic_lights)
        light = self._setup.parameters["daylight"]
        picture = self._renderer.render(state.x_m, state.y_m, state.yaw_rad, boxes, light)
        return cv2.cvtColor(picture, cv2.COLOR_BGRA2RGB)
