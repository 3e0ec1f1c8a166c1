"""SdcTraffic-v0: merge from a ramp into a motorway among other cars, in one or many worlds."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from sdc_common.machine_code import compiled
from sdc_experiments.learning import traffic_world as world
from sdc_experiments.learning.environment import ACTIONS, SdcEnvironment
from sdc_experiments.learning.observation import ENTRIES, TICK_S, checked_action
from sdc_experiments.learning.road_table import CROSS_TRACK, S
from sdc_experiments.learning.traffic_world import HORIZON_M, LANE_M, LENGTH_M, RAMP_M, RING_M
from sdc_experiments.learning.vector_environment import SdcVectorEnvironment

START_MPS = 15.0  # speed at the start of a drive, on the ramp
END_M = 400.0  # place on the ring at which a drive ends
LIMIT_MPS = 27.8
_MIDDLE_M = 1.0  # greatest distance to the middle of a lane at the end of a drive
_WEIGHT = 0.1
OPEN_M = 300.0  # distance to the end of a lane that does not end
_AROUND = (
    ("ends_m", 0.0, OPEN_M),
    ("ahead_m", -LENGTH_M, HORIZON_M),
    ("ahead_mps", -100.0, 100.0),
    ("behind_m", -LENGTH_M, HORIZON_M),
    ("behind_mps", -100.0, 100.0),
)
_LANES = ("left", "own", "right")
TRAFFIC_ENTRIES = (
    *ENTRIES[:5],
    *((f"{lane}_{name}", low, high) for lane in _LANES for name, low, high in _AROUND),
)
TRAFFIC_NAMES = tuple(name for name, _, _ in TRAFFIC_ENTRIES)
# Of the plan: pixels per metre, and red, green, blue.
_PIXELS, _GREY, _WHITE, _GREEN = 4, 90, 230, (60, 110, 60)
_OWN, _OTHER = (230, 80, 60), (90, 160, 240)


class TrafficVectorEnvironment(SdcVectorEnvironment):
    """N worlds, each with our car and others.

    Args:
        num_envs: number of worlds, N
        others: number of other cars in each world
        lanes: number of lanes beside the ramp
        threads, autoreset_mode, render_mode: see SdcVectorEnvironment

    Raises:
        ValueError: an argument is not valid
    """

    STATUSES = (*SdcVectorEnvironment.STATUSES, "collision")

    def __init__(
        self,
        num_envs: int = 1,
        others: int = 49,
        lanes: int = 2,
        threads: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
    ):
        if lanes < 1:
            raise ValueError(f"lanes must be at least 1, got {lanes}")
        most = int(lanes * RING_M / (4.0 * LENGTH_M))
        if not 0 <= others <= most:
            raise ValueError(f"others must be 0 to {most} on {lanes} lanes, got {others}")
        super().__init__(
            num_envs,
            route=[{"straight_m": END_M + HORIZON_M}],
            threads=threads,
            autoreset_mode=autoreset_mode,
            render_mode=render_mode,
        )
        bounds = np.array([entry[1:] for entry in TRAFFIC_ENTRIES], np.float32).T
        self.single_observation_space = gymnasium.spaces.Box(*bounds)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._lanes, self._ticks = lanes + 1, np.zeros(num_envs, int)
        self._cars = np.zeros((num_envs, 6, others + 1))
        self._order = np.tile(np.arange(others + 1), (num_envs, 1))
        self._near = np.zeros((num_envs, self._lanes, 4))
        self._hits = np.zeros(num_envs, bool)
        self._move = compiled(
            world.move_others,
            world.is_in,
            world.acceleration,
            world.advantage,
            world.sort_along,
            world.find_neighbours,
            world.change_lane,
        )
        self._look = compiled(world.look_around, world.is_in)
        self._randoms = [seeding.np_random(None)[0] for _ in range(num_envs)]

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Place our cars on their ramps; the others of world i are drawn by seed + i or entry i.

        The option "reset_mask", (N,) bool, resets only these worlds.
        """
        self._check_reset(seed, options)
        seeds = [seed + i for i in range(self.num_envs)] if isinstance(seed, int) else seed
        for i in np.flatnonzero((options or {}).get("reset_mask", self._all)):
            if seeds is not None and seeds[i] is not None:
                self._randoms[i] = seeding.np_random(seeds[i])[0]
        return super().reset(seed=seed, options=options)

    def _start(self, cars: np.ndarray) -> None:
        super()._start(cars)
        self._places[CROSS_TRACK, cars] = -LANE_M
        self._fleet.state["y_m"][cars] -= LANE_M
        self._fleet.state["speed_mps"][cars] = START_MPS
        lanes, number = self._lanes - 1, np.arange(self._cars.shape[2] - 1)
        between_m = RING_M / np.bincount(number % lanes, minlength=lanes)[number % lanes]
        self._ticks[cars] = 0
        for i in cars:
            car, drawn = self._cars[i, :, :-1], self._randoms[i].random((3, len(number)))
            car[world.S] = (number // lanes + 0.6 * drawn[0]) * between_m
            car[world.WISH], car[world.TIME_GAP] = 22.0 + 10.0 * drawn[1], 0.8 + drawn[2]
            car[world.SPEED] = 0.9 * car[world.WISH]
            car[world.LANE] = 1 + number % lanes
            car[world.Y] = LANE_M * (car[world.LANE] - 1)
            self._order[i] = np.arange(len(number) + 1)
        self._look_around()

    def _look_around(self) -> None:
        """Put our cars among the others and find what is near them."""
        own, places = self._cars[:, :, -1], self._places
        own[:, world.S], own[:, world.Y] = places[S], places[CROSS_TRACK]
        own[:, world.SPEED] = self._fleet.state["speed_mps"]
        own[:, world.LANE] = np.clip(np.rint(places[CROSS_TRACK] / LANE_M) + 1, 0, self._lanes - 1)
        own[:, world.WISH], own[:, world.TIME_GAP] = LIMIT_MPS, 1.5
        self._fleet.share(self._look, self._cars, self._near, self._hits)

    @property
    def _offset_m(self) -> np.ndarray:
        """Return the offset of our cars from the middle of their lanes (N,) [m]."""
        return self._cars[:, world.Y, -1] - LANE_M * (self._cars[:, world.LANE, -1] - 1)

    def _ends(self) -> np.ndarray:
        self._ticks += 1
        self._fleet.share(self._move, self._cars, self._order, self._lanes, self._ticks, TICK_S)
        self._look_around()
        offset_m, s_m = np.abs(self._offset_m), self._places[S]
        is_past_ramp = (self._cars[:, world.LANE, -1] == 0) & (s_m > RAMP_M)
        completed = (s_m >= END_M) & (offset_m < _MIDDLE_M)
        off_road = (offset_m > 0.5 * LANE_M) | is_past_ramp
        return np.where(self._hits, 3, np.where(off_road, 2, completed))

    def _rewards(self, before_m: np.ndarray, speed: np.ndarray) -> np.ndarray:
        progress = (self._places[S] - before_m) / (LIMIT_MPS * TICK_S)
        return progress - _WEIGHT * (self._offset_m**2 + np.maximum(speed - LIMIT_MPS, 0.0) ** 2)

    def _observe(self) -> np.ndarray:
        # Beside the lanes that there are, one without room.
        around = np.zeros((self.num_envs, self._lanes + 2, len(_AROUND)))
        around[:, 1:-1, 1:] = self._near
        around[:, 2:-1, 0] = OPEN_M
        around[:, 1, 0] = np.maximum(RAMP_M - self._places[S], 0.0)
        lanes = self._cars[:, world.LANE, -1].astype(int)[:, None] + [2, 1, 0]
        around = np.take_along_axis(around, lanes[:, :, None], axis=1)
        seen = np.hstack([super()._observe()[:, :5], around.reshape(self.num_envs, -1)])
        seen[:, 1] = self._offset_m
        space = self.single_observation_space
        return np.clip(seen.astype(np.float32), space.low, space.high)

    def render(self) -> tuple[np.ndarray, ...] | None:
        """Return the road around each of our cars from above (height, width, 3) RGB."""
        return None if self.render_mode is None else tuple(map(self._plan, self._cars))

    def _plan(self, car: np.ndarray) -> np.ndarray:
        height, own_m = round(_PIXELS * LANE_M), car[world.S, -1]
        picture = np.full((height * self._lanes, int(2 * _PIXELS * HORIZON_M), 3), _GREY, np.uint8)
        picture[::height] = _WHITE
        picture[-height:, int(_PIXELS * max(RAMP_M - own_m + HORIZON_M, 0.0)) :] = _GREEN
        for k in range(car.shape[1]):
            ahead_m = (car[world.S, k] - own_m + 0.5 * RING_M) % RING_M - 0.5 * RING_M
            x = max(round(_PIXELS * (ahead_m + HORIZON_M - 0.5 * LENGTH_M)), 0)
            y = round(_PIXELS * (LANE_M * (self._lanes - 1.5) - car[world.Y, k] - 1.0))
            colour = _OWN if k == car.shape[1] - 1 else _OTHER
            picture[max(y, 0) : y + 8, x : max(x + 19, 0)] = colour
        return picture


class TrafficEnvironment(gymnasium.Env):
    """One of the worlds of TrafficVectorEnvironment, whose arguments it takes."""

    metadata = SdcEnvironment.metadata

    def __init__(self, others: int = 49, lanes: int = 2, render_mode: str | None = None):
        self._world = TrafficVectorEnvironment(1, others, lanes, 1, "Disabled", render_mode)
        self.action_space, self.render_mode = ACTIONS, render_mode
        self.observation_space = self._world.single_observation_space

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Place our car on the ramp; the seed draws the others."""
        super().reset(seed=seed)
        seen, info = self._world.reset(seed=seed)
        return seen[0], _first(info)

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Drive for a tick of 0.05 s."""
        actions = checked_action(action, (2,))[None]
        seen, reward, ended, truncated, info = self._world.drive(actions)
        return seen[0], reward.item(), ended.item(), truncated.item(), _first(info)

    def render(self) -> np.ndarray | None:
        """Return the road around our car from above (height, width, 3) RGB."""
        pictures = self._world.render()
        return pictures[0] if pictures else None


def _first(info: dict[str, Any]) -> dict[str, Any]:
    return {name: values[0] for name, values in info.items() if not name.startswith("_")}
