#!/usr/bin/env python3
"""Measure the time to draw a frame with a full trail.

This is not a test. Run it by hand, without a screen under xvfb-run:

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

CONFIG = Path(__file__).resolve().parents[1] / "config" / "qt_interface.yaml"


def new_scene(trail_points):
    scene = Scene(
        read_settings({**yaml.safe_load(CONFIG.read_text()), "trail_points": trail_points})
    )
    points = [
        (i, 350.0 * math.cos(math.pi * i / 15), 150.0 * math.sin(math.pi * i / 15))
        for i in range(30)
    ]
    scene.set_world(WorldSizes(800.0, 450.0, 20.0, 100.0, False), points)
    scene.set_sensed(points[:4])
    scene.set_target(points[2])
    return scene


def drive(scene, step):
    angle = 0.0117 * step  # about 4 u per step
    radius = 1.0 + 0.1 * math.sin(0.0007 * step)  # laps that do not overlap
    scene.set_car(
        350.0 * radius * math.cos(angle), 150.0 * radius * math.sin(angle), angle, step / 30.0
    )


def time_frames(field, frames, first_step):
    """Return the seconds per frame with a cached trail, with a redrawn trail, and while zooming."""
    cached, redrawn, zoomed = [], [], []
    for frame in range(frames):
        if frame % 2 == 0:
            drive(field.scene, first_step + frame // 2)
        is_cached = field._ground_key[2] == field.scene.trail.version
        field.repaint()
        (cached if is_cached else redrawn).append(field.paint_seconds)
    for frame in range(60):
        field.zoom(1.02 if frame % 2 else 1 / 1.02)
        field.repaint()
        zoomed.append(field.paint_seconds)
    return cached, redrawn, zoomed


def frame_rate(application, window):
    """Return the frames per second after 5 seconds of normal operation."""
    begin = time.perf_counter()
    while time.perf_counter() - begin < 5.0:
        application.processEvents()
    times = window._frame_times
    return (len(times) - 1) / (times[-1] - times[0])


def main(trail_points, frames):
    application = QApplication([])
    scene = new_scene(trail_points)
    window = Window(scene)
    window.show()
    for step in range(trail_points + 200):
        drive(scene, step)
    for _ in range(20):
        application.processEvents()
    measured = time_frames(window.field, frames, trail_points + 200)
    size = f"{window.field.width()} x {window.field.height()} pixels"
    print(f"{len(scene.trail)} trail points, {size}")
    names = ("frame", "frame in which a piece of trail was finished", "frame while zooming")
    for name, seconds in zip(names, measured):
        if seconds:
            print(
                f"{name}: median {1000 * statistics.median(seconds):.2f} ms, "
                f"worst {1000 * max(seconds):.2f} ms ({len(seconds)} frames)"
            )
    print(f"frame rate: {frame_rate(application, window):.1f} frames/s")


if __name__ == "__main__":
    main(*(int(argument) for argument in (sys.argv[1:] + ["10000", "2000"][len(sys.argv) - 1 :])))
