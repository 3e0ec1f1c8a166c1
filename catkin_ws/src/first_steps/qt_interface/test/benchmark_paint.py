#!/usr/bin/env python3
"""Measures how long the window takes to draw a frame with a full trail. Not a test: run it by hand, under xvfb-run
if there is no screen.

    xvfb-run -a python3 benchmark_paint.py [trail points] [frames]
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from pathlib import Path

import yaml
from PyQt5.QtWidgets import QApplication

from qt_interface.scene import Scene
from qt_interface.settings import WorldSizes, read_settings
from qt_interface.window import Window


def main(trail_points, frames):
    application = QApplication([])
    config = Path(__file__).resolve().parents[1] / "config" / "qt_interface.yaml"
    scene = Scene(
        read_settings({**yaml.safe_load(config.read_text()), "trail_points": trail_points})
    )
    points = [
        (i, 350.0 * math.cos(math.pi * i / 15), 150.0 * math.sin(math.pi * i / 15))
        for i in range(30)
    ]
    scene.set_world(WorldSizes(800.0, 450.0, 20.0, 100.0, False), points)
    scene.set_sensed(points[:4])
    scene.set_target(points[2])
    window = Window(scene)
    window.show()
    field = window.field

    def drive(step):
        angle = 0.0117 * step  # about 4 u a step
        radius = 1.0 + 0.1 * math.sin(0.0007 * step)  # laps that do not cover one another
        scene.set_car(
            350.0 * radius * math.cos(angle), 150.0 * radius * math.sin(angle), angle, step / 30.0
        )

    for step in range(trail_points + 200):
        drive(step)
    for _ in range(20):
        application.processEvents()
    kept, anew = [], []
    for frame in range(frames):
        if frame % 2 == 0:
            drive(trail_points + 200 + frame // 2)
        version = scene.trail.version
        was_drawn = field._ground_key[2] == version
        field.repaint()
        (kept if was_drawn else anew).append(field.paint_seconds)
    zoomed = []
    for frame in range(60):
        field.zoom(1.02 if frame % 2 else 1 / 1.02)
        field.repaint()
        zoomed.append(field.paint_seconds)
    print(f"{len(scene.trail)} trail points, {field.width()} x {field.height()} pixels")
    for name, seconds in (
        ("frame", kept),
        ("frame in which a piece of trail was finished", anew),
        ("frame while zooming", zoomed),
    ):
        if seconds:
            print(
                f"{name}: median {1000 * statistics.median(seconds):.2f} ms, worst {1000 * max(seconds):.2f} ms "
                f"({len(seconds)} frames)"
            )
    begin = time.perf_counter()
    shown = 0
    while time.perf_counter() - begin < 5.0:
        application.processEvents()
        shown = len(window._frame_times)
    times = window._frame_times
    print(
        f"frame rate over the last {shown} frames: {(shown - 1) / (times[-1] - times[0]):.1f} frames/s"
    )


if __name__ == "__main__":
    main(*(int(argument) for argument in (sys.argv[1:] + ["10000", "2000"][len(sys.argv) - 1 :])))
