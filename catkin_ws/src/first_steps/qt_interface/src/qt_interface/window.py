"""The window: the field, the column beside it, the status bar, the keys."""

from __future__ import annotations

import math
import time
from collections import deque

from PyQt5.QtCore import Qt, QTimer, pyqtSignal
from PyQt5.QtGui import QKeySequence
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QMainWindow, QShortcut, QWidget

from qt_interface.field_widget import ZOOM_STEP, FieldWidget
from qt_interface.legend import Legend

SILENT_SECONDS = 1.0  # without a position of the car, until the status bar says so


class Window(QMainWindow):
    """Shows a scene. The slots take what is new; the signals say what the user wishes."""

    car_dragged = pyqtSignal(float, float)
    waypoint_wished = pyqtSignal(float, float)
    pause_wished = pyqtSignal(bool)
    reset_wished = pyqtSignal()

    def __init__(self, scene):
        super().__init__()
        self.scene = scene
        self.setWindowTitle("First steps: the red square that finds its way")
        self.field = FieldWidget(scene)
        self.legend = Legend(scene)
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
        self.field.car_dragged.connect(self.car_dragged)
        self.field.waypoint_wished.connect(self.waypoint_wished)
        self.field.click_refused.connect(lambda text: self.statusBar().showMessage(text, 3000))
        self.add_keys(("Space", "P"), self.toggle_pause)
        self.add_keys(("R",), self.reset_wished.emit)
        self.add_keys(("F", "0"), self.field.fit_view)
        self.add_keys(("+", "="), lambda: self.field.zoom(ZOOM_STEP))
        self.add_keys(("-",), lambda: self.field.zoom(1.0 / ZOOM_STEP))
        self.add_keys(("Q", "Ctrl+Q", "Ctrl+W", "Esc"), self.close)
        self._frame_times = deque(maxlen=60)
        self._frame_timer = QTimer(
            self, timerType=Qt.PreciseTimer, interval=int(1000.0 / scene.settings.frame_rate)
        )
        self._frame_timer.timeout.connect(self.next_frame)
        self._frame_timer.start()
        self._status_timer = QTimer(self, interval=200)
        self._status_timer.timeout.connect(self.update_status)
        self._status_timer.start()
        self.update_status()

    def add_keys(self, keys, action):
        """Does the action when one of the keys is pressed, once a press."""
        for key in keys:
            shortcut = QShortcut(QKeySequence(key), self)
            shortcut.setAutoRepeat(False)
            shortcut.activated.connect(action)

    # What is new
    def set_car(self, x, y, direction):
        """A position of the car came in."""
        self.scene.set_car(x, y, direction, time.monotonic())

    def set_laps(self, laps):
        """The count of laps came in."""
        self.scene.laps = laps
        self.legend.update()

    def set_paused(self, is_paused):
        """The world paused or went on."""
        self.scene.is_paused = is_paused

    def clear_trail(self):
        """The world was reset."""
        self.scene.trail.clear()

    # What happens by itself
    def toggle_pause(self):
        """Wishes for the other state than the one the world is in."""
        self.pause_wished.emit(not self.scene.is_paused)

    def next_frame(self):
        """Draws the field anew."""
        self._frame_times.append(time.monotonic())
        self.field.hold_car()
        self.field.update()

    def update_status(self):
        """Writes the status bar."""
        scene, labels = self.scene, self.labels
        is_silent = scene.silence(time.monotonic()) > SILENT_SECONDS
        labels["state"].setText(
            "paused" if scene.is_paused else "no car on /car_position" if is_silent else "running"
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
        labels["zoom"].setText(f"zoom {100.0 * self.field.view.scale:.0f} %")
        times = self._frame_times
        if len(times) > 1 and times[-1] > times[0]:
            labels["frames"].setText(f"{(len(times) - 1) / (times[-1] - times[0]):.0f} frames/s")
