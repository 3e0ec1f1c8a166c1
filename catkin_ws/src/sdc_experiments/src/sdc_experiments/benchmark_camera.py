"""Frames a second of the camera picture, beside one bare perspective warp of the same size.

    python3 -m sdc_experiments.benchmark_camera [--seconds 6] [--strip FILE.png]

Everything runs in one process with one OpenCV thread. The drive is made anew each time it is measured, so that the
figures hold the cost of laying out the ground along the way. The three things measured take turns, so that a busy
machine slows all of them. `--strip` writes a strip of frames instead.
"""

from __future__ import annotations

import argparse
import time

import cv2
import numpy as np

from sdc_sim.camera.bodies import Box
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.road import Road

STEP_M = 0.5  # 10 m/s at 20 Hz


def route(*pieces, step_m: float = 1.0) -> np.ndarray:
    """Waypoints (N, 2) of straights ('s', length_m) and arcs ('l' or 'r', radius_m, angle_rad), from the origin."""
    points, x, y, yaw = [(0.0, 0.0)], 0.0, 0.0, 0.0
    for kind, size, *rest in pieces:
        curvature = {"s": 0.0, "l": 1.0 / size, "r": -1.0 / size}[kind]
        length = size if kind == "s" else size * rest[0]
        count = max(1, int(np.ceil(length / step_m)))
        for _ in range(count):
            d = length / count
            turn = 0.5 * curvature * d
            chord = d * np.sinc(turn / np.pi)
            x, y, yaw = (
                x + chord * np.cos(yaw + turn),
                y + chord * np.sin(yaw + turn),
                yaw + 2.0 * turn,
            )
            points.append((x, y))
    return np.array(points)


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
    (14.0, 0.0, "car"),
    (27.0, 0.2, "car"),
    (18.0, 3.5, "car"),
    (40.0, 3.5, "car"),
    (60.0, 0.0, "car"),
    (11.0, -3.4, "pedestrian"),
    (22.0, 7.0, "pedestrian"),
    (32.0, -3.2, "pedestrian"),
    (35.0, 1.8, "obstacle"),
    (24.0, -3.0, "light"),
)
SIZES = {
    "car": (4.7, 2.0, 1.45),
    "pedestrian": (0.45, 0.6, 1.78),
    "obstacle": (1.0, 1.0, 1.0),
    "light": (0.5, 0.5, 4.2),
}
COLOURS = ((40, 40, 170), (160, 100, 40), (215, 215, 215), (60, 60, 60), (60, 140, 60))


def pose(road: Road, s_m: float, offset_m: float = 0.0) -> tuple:
    """x, y, yaw (m, m, rad) on the road, `offset_m` to the left of the route."""
    points, left = road.at([s_m])
    x, y = points[0] + offset_m * left[0]
    return float(x), float(y), float(np.arctan2(-left[0, 0], left[0, 1]))


def traffic(road: Road, s_m: float, placed=TRAFFIC) -> list:
    """Boxes on the road ahead of `s_m`."""
    boxes = []
    for k, (ahead, offset, kind) in enumerate(placed):
        x, y, yaw = pose(road, s_m + ahead, offset)
        oncoming = kind == "light" or (kind == "car" and offset > 2.0)
        colour = (
            (40, 40, 255)
            if kind == "light"
            else (30, 130, 235)
            if kind == "obstacle"
            else COLOURS[k % 5]
        )
        boxes.append(
            Box(
                x, y, yaw + (np.pi if oncoming else 0.0), *SIZES[kind], colour_bgr=colour, kind=kind
            )
        )
    return boxes


def strip() -> np.ndarray:
    """A strip of frames (960, 1920, 3) BGR: straight, roundabout, tight turn, crossing, traffic, night."""
    curvy = Road(route(*CURVY))
    ring = Road(route(("s", 60), ("r", 12, 0.8), ("l", 20, 5.6), ("r", 12, 0.8), ("s", 60)))
    cross = Road(route(("s", 120), ("l", 15, 4.71), ("s", 120)))
    shots = [
        (curvy, 30.0, (), 1.0),
        (ring, 75.0, TRAFFIC[1:2], 1.0),
        (curvy, 521.0, TRAFFIC[3:4], 1.0),
        (cross, 105.0, (), 1.0),
        (curvy, 190.0, TRAFFIC, 1.0),
        (curvy, 250.0, TRAFFIC, 0.25),
    ]
    frames = [
        Renderer(road).render(*pose(road, s), boxes=traffic(road, s, placed), light=light)[..., :3]
        for road, s, placed, light in shots
    ]
    return np.vstack([np.hstack(frames[:3]), np.hstack(frames[3:])])


def _frames_ms(road: Road, with_boxes: bool) -> list:
    renderer = Renderer(road)
    renderer.render(*pose(road, 0.0))
    spent = []
    for s in np.arange(0.0, road.length_m, STEP_M):
        at = pose(road, s)
        boxes = traffic(road, s) if with_boxes else ()
        start = time.perf_counter()
        renderer.render(*at, boxes=boxes)
        spent.append(1e3 * (time.perf_counter() - start))
    return spent


def bare_warp():
    """A function that makes one perspective warp (480, 640, 4) and returns it, always in the same memory."""
    source = np.random.RandomState(0).randint(0, 255, (1024, 1024, 4)).astype(np.uint8)
    target = np.empty((480, 640, 4), np.uint8)
    matrix = np.array([[1.0, 0.1, 3.0], [0.05, 1.1, 2.0], [1e-4, 2e-4, 1.0]])
    return lambda: cv2.warpPerspective(
        source, matrix, (640, 480), dst=target, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    )


def _warp_ms(count: int) -> list:
    warp = bare_warp()
    spent = []
    for _ in range(count):
        start = time.perf_counter()
        warp()
        spent.append(1e3 * (time.perf_counter() - start))
    return spent


def main() -> None:
    parser = argparse.ArgumentParser(description="frames a second of the camera picture")
    parser.add_argument("--seconds", type=float, default=6.0, help="how long to measure, about")
    parser.add_argument("--strip", metavar="FILE.png", help="write a strip of frames and stop")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    if options.strip:
        if not cv2.imwrite(options.strip, strip()):
            parser.error(f"cannot write {options.strip}")
        return
    road = Road(route(*CURVY))
    bare, empty, full = [], [], []
    end = time.perf_counter() + options.seconds
    while not bare or time.perf_counter() < end:
        bare += _warp_ms(300)
        empty += _frames_ms(road, False)
        full += _frames_ms(road, True)
    floor = float(np.mean(bare))
    print(f"route of {road.length_m:.0f} m, a frame every {STEP_M} m, 640 x 480, one thread")
    print(f"{'':24s}{'frames/s':>9s}{'mean ms':>9s}{'median':>8s}{'p99':>8s}{'/ warp':>8s}")
    for name, spent in (
        ("bare warpPerspective", bare),
        ("road and scenery", empty),
        ("and 10 boxes", full),
    ):
        mean = float(np.mean(spent))
        print(
            f"{name:24s}{1e3 / mean:9.0f}{mean:9.2f}{np.median(spent):8.2f}{np.percentile(spent, 99):8.2f}"
            f"{mean / floor:8.1f}"
        )


if __name__ == "__main__":
    main()
