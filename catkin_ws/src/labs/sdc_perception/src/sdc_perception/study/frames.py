"""Measure the detectors of lights and obstacles on held-out pictures, and print a table.

    python3 -m sdc_perception.study.frames [--frames N] [--weather NAME ...]

Each picture is searched alone, without tracking. The routes have seeds from 3001 on; each weather
has its own. Seeds 100 to 119 were used to choose parameters.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import partial

import cv2
import numpy as np

from sdc_common.configuration import node_config
from sdc_perception.light_detection import LightFinder, LightSettings, SeenLight
from sdc_perception.obstacle_detection import BodyFinder, ObstacleSettings, SeenBody
from sdc_perception.study.drives import WEATHERS
from sdc_perception.study.scenes import FRAMES_A_ROUTE, Scene, SceneMaker, TrueObject
from sdc_sim.camera.camera_model import CameraModel

FIRST_SEED = 3001
LIGHT_RANGE_M = 40.0  # lights farther away do not count
BODY_RANGE_M = 30.0  # bodies farther away do not count
_MOUNT_X_M = CameraModel().mount_x_m
# Columns by which a detection and the truth may differ [px].
_NEAR_PX = 4.0
HEAD = (
    f"| | pictures | all lights within {LIGHT_RANGE_M:g} m right | lights right, false "
    f"| distance error: median, 95 % | bodies within {BODY_RANGE_M:g} m found, false "
    "| distance error: median, 95 % | within 10 % | lights + bodies take |\n" + 9 * "|---" + "|"
)


@dataclass
class FrameScore:
    """Counts and errors over pictures."""

    frames: int = 0  # number of pictures
    right_frames: int = 0  # pictures in which all lights are right, and none is false
    # Relative error of the distance of each visible light in range, NaN where it is not found, or
    # with another colour
    light_errors: list[float] = field(default_factory=list)
    false_lights: int = 0  # detections without a light
    body_errors: list[float] = field(default_factory=list)  # the same of each visible body in range
    false_bodies: int = 0  # detections without a body
    # CPU time of lights and obstacles in each picture
    times_s: list[tuple[float, float]] = field(default_factory=list)

    def add(self, scene: Scene, lights: list[SeenLight], bodies: list[SeenBody]) -> None:
        """Add a picture."""
        light_errors, false_lights = _light_errors(scene, lights)
        body_errors, false_bodies = _body_errors(scene, bodies)
        self.frames += 1
        self.right_frames += bool(np.isfinite(light_errors).all()) and not false_lights
        self.light_errors += light_errors
        self.false_lights += false_lights
        self.body_errors += body_errors
        self.false_bodies += false_bodies

    def __add__(self, other: FrameScore) -> FrameScore:
        """Return the score of the pictures of both."""
        return FrameScore(
            *(getattr(self, field.name) + getattr(other, field.name) for field in fields(self))
        )

    def row(self, name: str) -> str:
        """Return a row of the table, see HEAD."""
        times = 1e3 * np.median(self.times_s, axis=0)
        body = np.abs(self.body_errors)
        near = np.mean(body[np.isfinite(body)] < 0.1) if np.isfinite(body).any() else 0.0
        cells = (
            name,
            f"{self.frames}",
            f"{100 * self.right_frames / self.frames:.2f} %",
            *_found_and_errors(self.light_errors, self.false_lights),
            *_found_and_errors(self.body_errors, self.false_bodies),
            f"{100 * near:.2f} %",
            f"{times[0]:.1f} + {times[1]:.1f} ms",
        )
        return f"| {' | '.join(cells)} |"


def _found_and_errors(errors: list[float], false: int) -> tuple[str, str]:
    """Return the cells of how many are found, and of the median and 95 % of their errors."""
    found = np.abs([error for error in errors if np.isfinite(error)] or [np.nan])
    median, most = np.percentile(found, [50, 95])
    count = f"{np.isfinite(errors).sum()} of {len(errors)}, {false}"
    return count, f"{100 * median:.1f} %, {100 * most:.1f} %"


def _light_errors(scene: Scene, found: list[SeenLight]) -> tuple[list[float], int]:
    """Return the error of each light in range, and the number of false ones."""
    errors, free = [], list(found)
    for light in scene.visible(lights=True):
        near = [detection for detection in free if _inside(light.pixel, detection.box)]
        for detection in near:
            free.remove(detection)
        if light.depth_m <= LIGHT_RANGE_M:
            right = len(near) == 1 and near[0].state == light.state
            errors.append(_error(near[0], light) if right else math.nan)
    return errors, _false_ones(free, LIGHT_RANGE_M, scene)


def _body_errors(scene: Scene, found: list[SeenBody]) -> tuple[list[float], int]:
    """Return the error of each body in range, and the number of false ones."""
    errors, free = [], list(found)
    for body in sorted(scene.visible(lights=False), key=lambda body: body.depth_m):
        near = [
            detection
            for detection in free
            if detection.kind == body.kind and _is_at(detection, body)
        ]
        best = min(
            near, key=lambda detection: abs(detection.x_m - _MOUNT_X_M - body.depth_m), default=None
        )
        if best is not None:
            free.remove(best)
        if body.depth_m <= BODY_RANGE_M:
            errors.append(math.nan if best is None else _error(best, body))
    return errors, _false_ones(free, BODY_RANGE_M, scene)


def _error(found: SeenLight | SeenBody, true: TrueObject) -> float:
    return (found.x_m - _MOUNT_X_M) / true.depth_m - 1.0


def _inside(pixel: Sequence[float], box: tuple[float, float, float, float]) -> bool:
    u, v = pixel
    left, top, right, bottom = box
    return left - _NEAR_PX < u < right + _NEAR_PX and top - _NEAR_PX < v < bottom + _NEAR_PX


def _is_at(found: SeenLight | SeenBody, true: TrueObject) -> bool:
    """Return whether the middle of a detection is in the columns of an object."""
    middle = 0.5 * (found.box[0] + found.box[2])
    return true.left - _NEAR_PX <= middle <= true.right + _NEAR_PX


def _false_ones(free: Sequence[SeenLight | SeenBody], range_m: float, scene: Scene) -> int:
    """Return how many detections within a range are none of the scene's hidden objects."""
    hidden = [body for body in scene.objects if not body.visible]
    return sum(
        detection.x_m < range_m and not any(_is_at(detection, body) for body in hidden)
        for detection in free
    )


def measure(weather: str, count: int, first_seed: int) -> FrameScore:
    """Return the score of some pictures in a weather of WEATHERS, with the lab's parameters."""
    intrinsic, score = CameraModel().intrinsic_matrix(), FrameScore()
    parameters = partial(node_config, "sdc_perception")
    light_settings = LightSettings.read(parameters("traffic_light_detector").__getitem__)
    body_settings = ObstacleSettings.read(parameters("obstacle_detector").__getitem__)
    light_finder = LightFinder(light_settings, intrinsic)
    body_finder = BodyFinder(body_settings, intrinsic)
    for scene in SceneMaker(first_seed, WEATHERS[weather]).scenes(count):
        times = [time.thread_time()]
        lights = light_finder.find(scene.picture)
        times.append(time.thread_time())
        bodies = body_finder.find(scene.picture)
        times.append(time.thread_time())
        score.times_s.append((times[1] - times[0], times[2] - times[1]))
        score.add(scene, lights, bodies)
    return score


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="measure the detectors of lights and obstacles")
    parser.add_argument("--frames", type=int, default=1000, help="pictures in each weather")
    parser.add_argument("--weather", nargs="+", choices=list(WEATHERS), default=["day", "dusk"])
    options = parser.parse_args()
    cv2.setNumThreads(1)
    print(HEAD)
    routes, scores = math.ceil(options.frames / FRAMES_A_ROUTE), []
    for number, weather in enumerate(options.weather):
        scores.append(measure(weather, options.frames, FIRST_SEED + number * routes))
        print(scores[-1].row(weather), flush=True)
    if len(scores) > 1:
        print(sum(scores, FrameScore()).row("all"))


if __name__ == "__main__":
    main()
