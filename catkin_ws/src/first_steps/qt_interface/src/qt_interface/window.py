"""The main window: the field, the legend next to it, the status bar and the keys."""

from __future__ import annotations

import math
import time
from collections import deque
from typing import Callable, Iterable

from PyQt5.QtCore import Qt, QTimer, pyqtSignal
from PyQt5.QtGui import QKeySequence
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QMainWindow, QShortcut, QWidget

from qt_interface.field_widget import ZOOM_STEP, FieldWidget
from qt_interface.legend import Legend
from qt_interface.scene import Scene

CAR_TIMEOUT_S = 1.0  # without a position of the car, before the status bar reports it


class Window(QMainWindow):
    """A window that shows a scene.

    Its signals, and those of its field, emit what the user requests with keys and mouse.
    """

    pause_requested = pyqtSignal(bool)
    reset_requested = pyqtSignal()

    def __init__(self, scene: Scene):
        super().__init__()
        self.scene = scene
        self.setWindowTitle("First steps: the red square that finds its way")
        self.field = FieldWidget(scene)
        self.legend = Legend()
        middle = QWidget()
        layout = QHBoxLayout(middle)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.field, 1)
        layout.addWidget(self.legend)
        self.setCentralWidget(middle)
        self.resize(scene.settings.window_width, scene.settings.window_height)
        self.labels = {name: QLabel() for name in ("state", "car", "points", "zoom", "frames")}
        for name, label in self.labels.items():
            label.setContentsMargins(8, 2, 8, 2)
            if name in ("zoom", "frames"):
                self.statusBar().addPermanentWidget(label)
            else:
                self.statusBar().addWidget(label)
        self.field.click_refused.connect(lambda text: self.statusBar().showMessage(text, 3000))
        self.add_keys(("Space", "P"), self.toggle_pause)
        self.add_keys(("R",), self.reset_requested.emit)
        self.add_keys(("F", "0"), self.field.fit_view)
        self.add_keys(("+", "="), lambda: self.field.zoom(ZOOM_STEP))
        self.add_keys(("-",), lambda: self.field.zoom(1.0 / ZOOM_STEP))
        self.add_keys(("Q", "Ctrl+Q", "Ctrl+W", "Esc"), self.close)
        self._frame_times: deque[float] = deque(maxlen=60)
        frame_ms = int(1000.0 / scene.settings.frame_rate)
        for interval, action in ((frame_ms, self.next_frame), (200, self.update_status)):
            timer = QTimer(self, timerType=Qt.PreciseTimer, interval=interval)
            timer.timeout.connect(action)
            timer.start()
        self.update_status()

    def add_keys(self, keys: Iterable[str], action: Callable[[], object]) -> None:
        """Call `action` whenever one of the keys is pressed, without auto-repeat."""
        for key in keys:
            shortcut = QShortcut(QKeySequence(key), self)
            shortcut.setAutoRepeat(False)
            shortcut.activated.connect(action)

    # New data
    def set_car(self, x: float, y: float, direction: float) -> None:
        """Set the car's position [u] and direction [rad]."""
        self.scene.set_car(x, y, direction, time.monotonic())

    def set_paused(self, is_paused: bool) -> None:
        """Set whether the world is paused."""
        self.scene.is_paused = is_paused

    # Keys and timers
    def toggle_pause(self) -> None:
        """Request a pause, or its end."""
        self.pause_requested.emit(not self.scene.is_paused)

    def next_frame(self) -> None:
        """Draw the field again."""
        self._frame_times.append(time.monotonic())
        self.field.hold_car()
        self.field.update()

    def update_status(self) -> None:
        """Update the status bar."""
        scene, labels = self.scene, self.labels
        has_no_car = scene.car_age(time.monotonic()) > CAR_TIMEOUT_S
        labels["state"].setText(
            "paused" if scene.is_paused else "no car on /car_position" if has_no_car else "running"
        )
        car = scene.car
        labels["car"].setText(
            f"car x {car.x:.0f}  y {car.y:.0f}  {math.degrees(car.direction):.0f}\N{DEGREE SIGN}"
            if car
            else ""
        )
        target = f", heading for {scene.target.idx}" if scene.target else ""
        labels["points"].setText(
            f"{len(scene.waypoints)} waypoints, {len(scene.sensed)} sensed{target}"
            if scene.waypoints
            else "no points on /world_waypoints"
        )
        labels["zoom"].setText(f"zoom {100.0 * self.field.scale:.0f} %")
        times = self._frame_times
        if len(times) > 1 and times[-1] > times[0]:
            labels["frames"].setText(f"{(len(times) - 1) / (times[-1] - times[0]):.0f} frames/s")
