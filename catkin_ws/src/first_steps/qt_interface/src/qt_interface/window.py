"""The main window: the field, the legend next to it, the status bar and the keys."""

from __future__ import annotations

import math
import time
from types import SimpleNamespace
from typing import Callable, Iterable

from PyQt5.QtCore import Qt, QTimer, pyqtSignal
from PyQt5.QtGui import QKeySequence
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QMainWindow, QShortcut, QWidget

from qt_interface.field import ZOOM_STEP, Field
from qt_interface.legend import Legend

CAR_TIMEOUT_S = 1.0  # without a position of the car, before the status bar reports it


class Window(QMainWindow):
    """A window whose signals, and those of its field, emit what the user requests."""

    pause_requested = pyqtSignal(bool)
    reset_requested = pyqtSignal()

    def __init__(self, settings: SimpleNamespace):
        """Open a window; `settings` are those of `qt_interface.settings`."""
        super().__init__()
        self.setWindowTitle("First steps: the red square that finds its way")
        self.field = Field(settings)
        self.legend = Legend()
        middle = QWidget()
        layout = QHBoxLayout(middle)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.field, 1)
        layout.addWidget(self.legend)
        self.setCentralWidget(middle)
        self.resize(settings.window_width, settings.window_height)
        self.status = QLabel(margin=4)
        self.statusBar().addWidget(self.status)
        self.field.click_refused.connect(lambda text: self.statusBar().showMessage(text, 3000))
        self.add_keys(("Space", "P"), self.toggle_pause)
        self.add_keys(("R",), self.reset_requested.emit)
        self.add_keys(("F", "0"), self.field.fit_view)
        self.add_keys(("+", "="), lambda: self.field.zoom_by(ZOOM_STEP))
        self.add_keys(("-",), lambda: self.field.zoom_by(1.0 / ZOOM_STEP))
        self.add_keys(("Q", "Ctrl+Q", "Ctrl+W", "Esc"), self.close)
        self._car_time = -math.inf
        frame_ms = int(1000.0 / settings.frame_rate)
        for interval, action in ((frame_ms, self.field.next_frame), (200, self.update_status)):
            timer = QTimer(self, timerType=Qt.PreciseTimer)
            timer.timeout.connect(action)
            timer.start(interval)
        self.update_status()

    def add_keys(self, keys: Iterable[str], action: Callable[[], object]) -> None:
        """Call `action` whenever one of the keys is pressed, without auto-repeat."""
        for key in keys:
            shortcut = QShortcut(QKeySequence(key), self)
            shortcut.setAutoRepeat(False)
            shortcut.activated.connect(action)

    def set_car(self, x: float, y: float, direction: float) -> None:
        """Set the car's position [u] and direction [rad]."""
        self._car_time = time.monotonic()
        self.field.set_car(x, y, direction)

    def set_paused(self, is_paused: bool) -> None:
        """Set whether the world is paused."""
        self.field.is_paused = is_paused

    # Keys and timers
    def toggle_pause(self) -> None:
        """Request a pause, or its end."""
        self.pause_requested.emit(not self.field.is_paused)

    def update_status(self) -> None:
        """Update the status bar."""
        field = self.field
        has_no_car = time.monotonic() - self._car_time > CAR_TIMEOUT_S
        parts = [
            "paused" if field.is_paused else "no car on /car_position" if has_no_car else "running"
        ]
        if field.pose is not None:
            x, y, direction = field.pose
            parts.append(f"car x {x:.0f}  y {y:.0f}  {math.degrees(direction):.0f}\N{DEGREE SIGN}")
        target = f", heading for {field.target.idx}" if field.target else ""
        parts.append(
            f"{len(field.waypoints)} waypoints, {len(field.sensed)} sensed{target}"
            if field.waypoints
            else "no points on /world_waypoints"
        )
        self.status.setText("     ".join([*parts, f"zoom {100.0 * field.zoom:.0f} %"]))
