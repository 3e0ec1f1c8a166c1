"""Benchmark of the camera picture against one bare perspective warp of the same size.

    python3 -m sdc_experiments.benchmark_camera [--seconds 6] [--strip FILE.png]

Everything runs in one process with one OpenCV thread. Each measurement renders the route with a new
renderer, so that it includes the rasterization of the ground. The three measurements alternate, so
that other programs on the machine slow all of them. `--strip` writes a strip of frames instead.
"""

from __future__ import annotations

import argparse
import time
from typing import Any, Callable, NamedTuple, Sequence

import cv2
import numpy as np

from sdc_sim.camera.boxes import Box
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.road import Road

STEP_M = 0.5  # 10 m/s at 20 Hz
_WARPS_PER_ROUND = 300


class Actor(NamedTuple):
    """A body on the road, relative to the car.

    Attributes:
        ahead_m: distance along the route [m]
        left_m: distance to the left of the route [m]
        kind: kind of the Box
    """

    ahead_m: float
    left_m: float
    kind: str


class Shot(NamedTuple):
    """A frame of the strip.

    Attributes:
        road: the road
        s_m: position of the car along it [m]
        actors: bodies on the road
        light: brightness, 0..1
    """

    road: Road
    s_m: float
    actors: Sequence[Actor] = ()
    light: float = 1.0


CURVY = (
    ("s", 80),
    ("l", 40, 1.2),
    ("s", 60),
    ("r", 25, 1.6),
    ("s", 120),
    ("r", 60, 0.9),
    ("l", 20, 1.8),
    ("s", 90),
    ("l", 4, 1.57),
    ("s", 80),
    ("r", 15, 1.57),
    ("s", 150),
)
TRAFFIC = (
    Actor(14.0, 0.0, "car"),
    Actor(27.0, 0.2, "car"),
    Actor(18.0, 3.5, "car"),
    Actor(40.0, 3.5, "car"),
    Actor(60.0, 0.0, "car"),
    Actor(11.0, -3.4, "pedestrian"),
    Actor(22.0, 7.0, "pedestrian"),
    Actor(32.0, -3.2, "pedestrian"),
    Actor(35.0, 1.8, "obstacle"),
    Actor(24.0, -3.0, "light"),
)
# Length, width and height [m].
_SIZES = {
    "car": (4.7, 2.0, 1.45),
    "pedestrian": (0.45, 0.6, 1.78),
    "obstacle": (1.0, 1.0, 1.0),
    "light": (0.5, 0.5, 4.2),
}
_COLOURS_BGR = ((40, 40, 170), (160, 100, 40), (215, 215, 215), (60, 60, 60), (60, 140, 60))
_FIXED_COLOURS_BGR = {"light": (40, 40, 255), "obstacle": (30, 130, 235)}


def route(*pieces: tuple, step_m: float = 1.0) -> np.ndarray:
    """Return the waypoints of straights and arcs from the origin along x.

    Args:
        *pieces: ('s', length [m]), ('l', radius [m], angle [rad]) or ('r', radius [m], angle [rad])
        step_m: greatest distance between waypoints [m]

    Returns:
        waypoints (N, 2) [m]
    """
    points, x, y, yaw = [(0.0, 0.0)], 0.0, 0.0, 0.0
    for kind, size, *rest in pieces:
        curvature = {"s": 0.0, "l": 1.0 / size, "r": -1.0 / size}[kind]
        length = size if kind == "s" else size * rest[0]
        count = max(1, int(np.ceil(length / step_m)))
        for _ in range(count):
            d = length / count
            turn = 0.5 * curvature * d
            chord = d * np.sinc(turn / np.pi)
            x += chord * np.cos(yaw + turn)
            y += chord * np.sin(yaw + turn)
            yaw += 2.0 * turn
            points.append((x, y))
    return np.array(points)


def pose(road: Road, s_m: float, left_m: float = 0.0) -> tuple[float, float, float]:
    """Return a pose on the road, along it.

    Args:
        road: the road
        s_m: distance along the route [m]
        left_m: distance to the left of the route [m]

    Returns:
        x [m], y [m] and yaw [rad]
    """
    points, left = road.at(np.array([s_m]))
    x, y = points[0] + left_m * left[0]
    return float(x), float(y), float(np.arctan2(-left[0, 0], left[0, 1]))


def traffic(road: Road, s_m: float, actors: Sequence[Actor] = TRAFFIC) -> list[Box]:
    """Return boxes on the road ahead of a position.

    Args:
        road: the road
        s_m: position of the car along the route [m]
        actors: the bodies; cars in the left lane and traffic lights face the car
    """
    boxes = []
    for k, (ahead_m, left_m, kind) in enumerate(actors):
        x, y, yaw = pose(road, s_m + ahead_m, left_m)
        oncoming = kind == "light" or (kind == "car" and left_m > 2.0)
        colour = _FIXED_COLOURS_BGR.get(kind, _COLOURS_BGR[k % len(_COLOURS_BGR)])
        yaw += np.pi if oncoming else 0.0
        boxes.append(Box(x, y, yaw, *_SIZES[kind], colour_bgr=colour, kind=kind))
    return boxes


def strip() -> np.ndarray:
    """Return a strip of six frames (960, 1920, 3) BGR.

    They show a straight, a roundabout, a tight turn, a crossing, traffic, and dusk.
    """
    curvy = Road(route(*CURVY))
    ring = Road(route(("s", 60), ("r", 12, 0.8), ("l", 20, 5.6), ("r", 12, 0.8), ("s", 60)))
    crossing = Road(route(("s", 120), ("l", 15, 4.71), ("s", 120)))
    shots = (
        Shot(curvy, 30.0),
        Shot(ring, 75.0, TRAFFIC[1:2]),
        Shot(curvy, 521.0, TRAFFIC[3:4]),
        Shot(crossing, 105.0),
        Shot(curvy, 190.0, TRAFFIC),
        Shot(curvy, 250.0, TRAFFIC, light=0.25),
    )
    frames = [_frame(shot) for shot in shots]
    return np.vstack([np.hstack(frames[:3]), np.hstack(frames[3:])])


def _frame(shot: Shot) -> np.ndarray:
    x, y, yaw = pose(shot.road, shot.s_m)
    boxes = traffic(shot.road, shot.s_m, shot.actors)
    return Renderer(shot.road).render(x, y, yaw, boxes, shot.light)[..., :3]


def bare_warp() -> Callable[[], np.ndarray]:
    """Return a function that warps a fixed image to (480, 640, 4), always in the same memory."""
    source = np.random.RandomState(0).randint(0, 255, (1024, 1024, 4)).astype(np.uint8)
    target = np.empty((480, 640, 4), np.uint8)
    matrix = np.array([[1.0, 0.1, 3.0], [0.05, 1.1, 2.0], [1e-4, 2e-4, 1.0]])
    return lambda: cv2.warpPerspective(
        source, matrix, (640, 480), dst=target, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    )


def _milliseconds(function: Callable[..., Any], *arguments: Any) -> float:
    """Return the duration of a call [ms]."""
    start = time.perf_counter()
    function(*arguments)
    return 1e3 * (time.perf_counter() - start)


def _warps_ms() -> list[float]:
    warp = bare_warp()
    return [_milliseconds(warp) for _ in range(_WARPS_PER_ROUND)]


def _frames_ms(road: Road, actors: Sequence[Actor]) -> list[float]:
    """Return the duration of each frame along the road [ms]."""
    renderer = Renderer(road)
    renderer.render(*pose(road, 0.0))
    spent = []
    for s_m in np.arange(0.0, road.length_m, STEP_M):
        x, y, yaw = pose(road, s_m)
        spent.append(_milliseconds(renderer.render, x, y, yaw, traffic(road, s_m, actors)))
    return spent


def _benchmark(seconds: float) -> None:
    road = Road(route(*CURVY))
    names = ("bare warpPerspective", "road and scenery", "and 10 boxes")
    spent: dict[str, list[float]] = {name: [] for name in names}
    end = time.perf_counter() + seconds
    while not spent[names[0]] or time.perf_counter() < end:
        spent[names[0]] += _warps_ms()
        spent[names[1]] += _frames_ms(road, ())
        spent[names[2]] += _frames_ms(road, TRAFFIC)
    warp_ms = np.mean(spent[names[0]])
    print(f"route of {road.length_m:.0f} m, a frame every {STEP_M} m, 640 x 480, one thread")
    print(f"{'':24s}{'frames/s':>9s}{'mean ms':>9s}{'median':>8s}{'p99':>8s}{'/ warp':>8s}")
    for name, times in spent.items():
        mean, median, p99 = np.mean(times), np.median(times), np.percentile(times, 99)
        print(f"{name:24s}{1e3 / mean:9.0f}{mean:9.2f}{median:8.2f}{p99:8.2f}{mean / warp_ms:8.1f}")


def main() -> None:
    """Run the benchmark, or write the strip of frames."""
    parser = argparse.ArgumentParser(description="measure the frames per second of the camera")
    parser.add_argument("--seconds", type=float, default=6.0, help="approximate duration")
    parser.add_argument("--strip", metavar="FILE.png", help="write a strip of frames and exit")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    if not options.strip:
        _benchmark(options.seconds)
    elif not cv2.imwrite(options.strip, strip()):
        parser.error(f"cannot write {options.strip}: use an existing folder and the ending .png")


if __name__ == "__main__":
    main()
