"""The field on the screen: draw the scene, and convert mouse and wheel events into signals."""

from __future__ import annotations

import math
import time

from PyQt5.QtCore import QPoint, QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent, QPainter, QPaintEvent, QResizeEvent, QTransform, QWheelEvent
from PyQt5.QtWidgets import QWidget

from qt_interface import painting
from qt_interface.scene import Scene

CLICK_PIXELS = 4  # a press that moves at most this far is a click
GRAB_PIXELS = 14  # smallest distance from its centre at which the car can be grabbed
MARGIN_PIXELS = 30  # around the field when all of it is visible
ZOOM_STEP = 1.15  # of one notch of the wheel
SCALE_MIN, SCALE_MAX = 0.02, 40.0  # pixels per field unit


def fit(extent: QRectF, width: int, height: int) -> QTransform:
    """Return the transformation from field units to pixels that shows an area.

    On the field y points up, on the screen down.

    Args:
        extent: the area [u]
        width: width of the widget [pixels]
        height: height of the widget [pixels]
    """
    room_x, room_y = max(width - 2 * MARGIN_PIXELS, 1), max(height - 2 * MARGIN_PIXELS, 1)
    scale = min(room_x / max(extent.width(), 1.0), room_y / max(extent.height(), 1.0))
    scale = min(max(scale, SCALE_MIN), SCALE_MAX)
    view = QTransform.fromTranslate(width / 2.0, height / 2.0).scale(scale, -scale)
    return view.translate(-extent.center().x(), -extent.center().y())


class FieldWidget(QWidget):
    """A widget that shows a Scene; its signals carry field units, and it changes only its view."""

    car_dragged = pyqtSignal(float, float)
    waypoint_requested = pyqtSignal(float, float)
    click_refused = pyqtSignal(str)

    def __init__(self, scene: Scene, parent: QWidget | None = None):
        super().__init__(parent)
        self.scene = scene
        self.setMinimumSize(320, 240)
        self.setMouseTracking(True)
        self.setAttribute(Qt.WA_OpaquePaintEvent)
        self.view = fit(QRectF(), 320, 240)
        self.held_car: tuple[float, float] | None = None  # where the mouse holds the car [u]
        self._is_fitted = True
        self._press: QPoint | None = None
        self._last_mouse = QPoint()
        self._is_panning = False

    # View
    def fit_view(self) -> None:
        """Show the whole field, also after the size of the window or of the field changes."""
        self._is_fitted = True
        self.view = fit(self.scene.extent(), self.width(), self.height())

    def zoom(self, factor: float, pixel: QPointF | None = None) -> None:
        """Scale the view by `factor` around a pixel, by default the middle of the widget."""
        pixel = pixel or QPointF(self.width() / 2.0, self.height() / 2.0)
        self._is_fitted = False
        factor = min(max(factor, SCALE_MIN / self.scale), SCALE_MAX / self.scale)
        zoomed = QTransform.fromTranslate(pixel.x(), pixel.y()).scale(factor, factor)
        self.view = self.view * zoomed.translate(-pixel.x(), -pixel.y())

    @property
    def scale(self) -> float:
        """Pixels per field unit."""
        return self.view.m11()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 (Qt's name)
        """Keep the centre of the view in the middle of the widget."""
        grown = event.size() - event.oldSize()
        self._pan(grown.width() / 2.0, grown.height() / 2.0)

    def _pan(self, pixels_x: float, pixels_y: float) -> None:
        self.view = self.view * QTransform.fromTranslate(pixels_x, pixels_y)

    # Mouse
    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Grab the car, or begin a click or a pan."""
        self._press = self._last_mouse = event.pos()
        self._is_panning = event.button() != Qt.LeftButton
        if event.button() == Qt.LeftButton and self._is_over_car(event.pos()):
            self.held_car = self._field_point(event.pos())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Carry the car or pan, and set the cursor that shows what a press does here."""
        if self.held_car is not None:
            self.held_car = self._field_point(event.pos())
            self.hold_car()
        elif self._press is not None:
            distance = (event.pos() - self._press).manhattanLength()
            self._is_panning = self._is_panning or distance > CLICK_PIXELS
            if self._is_panning:
                moved = event.pos() - self._last_mouse
                self._is_fitted = False
                self._pan(moved.x(), moved.y())
        self._last_mouse = event.pos()
        over = self.held_car is not None or self._is_over_car(event.pos())
        self.setCursor(Qt.OpenHandCursor if over else Qt.CrossCursor)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Release the car, or end a click and request a waypoint there."""
        point = self._field_point(event.pos())
        if self.held_car is not None:
            self.car_dragged.emit(*point)
        elif self._press is not None and not self._is_panning:
            if self.scene.contains(*point):
                self.waypoint_requested.emit(*point)
            else:
                self.click_refused.emit(
                    "That is outside the walls: click inside to add a waypoint."
                )
        self.held_car = self._press = None
        self._is_panning = False

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 (Qt's name)
        """Zoom around the mouse."""
        self.zoom(ZOOM_STEP ** (event.angleDelta().y() / 120.0), event.position())

    def hold_car(self) -> None:
        """Emit the position of a held car again, so that it does not drive away from the mouse."""
        if self.held_car is not None:
            self.car_dragged.emit(*self.held_car)

    def _field_point(self, pixel: QPoint) -> tuple[float, float]:
        return self.view.inverted()[0].map(float(pixel.x()), float(pixel.y()))

    def _is_over_car(self, pixel: QPoint) -> bool:
        car = self.scene.car_at(time.monotonic())
        reach = max(GRAB_PIXELS, 0.7 * self.scene.car_size * self.scale)
        return car is not None and (
            math.dist((pixel.x(), pixel.y()), self.view.map(car.x, car.y)) <= reach
        )

    # Painting
    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Draw a frame; a held car is where the mouse holds it."""
        if self._is_fitted:
            self.fit_view()
        car = self.scene.car_at(time.monotonic())
        if car is not None and self.held_car is not None:
            car = car._replace(x=self.held_car[0], y=self.held_car[1])
        painting.draw(QPainter(self), self.scene, self.view, car)
