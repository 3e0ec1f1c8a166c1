"""The field on the screen: draw the scene, and convert mouse and wheel events into signals."""

from __future__ import annotations

import math
import time
from typing import Iterable

from PyQt5.QtCore import QPoint, QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import (
    QColor,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPixmap,
    QPolygonF,
    QResizeEvent,
    QTransform,
    QWheelEvent,
)
from PyQt5.QtWidgets import QWidget

from qt_interface import painting
from qt_interface.scene import Point, Pose, Scene
from qt_interface.view import View, fit, nice_step

CLICK_PIXELS = 4  # a press that moves at most this far is a click
GRAB_PIXELS = 14  # smallest distance from its centre at which the car can be grabbed
MARGIN_PIXELS = 30  # around the field when all of it is visible
ZOOM_STEP = 1.15  # of one notch of the wheel
GRID_PIXELS = 60  # largest distance of two grid lines
FADE_PIECES = 16  # a trail with fewer pieces does not fade completely
LABEL_PIXELS = 24  # smallest distance of two numbered waypoints


def labelled_points(waypoints: Iterable[Point], view: View) -> set[Point]:
    """Return the waypoints that have room for a number; earlier waypoints have priority."""
    taken: dict[tuple[int, int], list[tuple[float, float]]] = {}
    labelled = set()
    for point in waypoints:
        x, y = view.to_pixel(point.x, point.y)
        column, row = math.floor(x / LABEL_PIXELS), math.floor(y / LABEL_PIXELS)
        neighbours = [(column + i, row + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        is_free = all(
            math.hypot(x - taken_x, y - taken_y) >= LABEL_PIXELS
            for cell in neighbours
            for taken_x, taken_y in taken.get(cell, ())
        )
        if is_free:
            taken.setdefault((column, row), []).append((x, y))
            labelled.add(point)
    return labelled


class FieldWidget(QWidget):
    """A widget that shows a Scene; its signals carry field units, and it changes only its view."""

    car_dragged = pyqtSignal(float, float)
    waypoint_requested = pyqtSignal(float, float)
    click_refused = pyqtSignal(str)
    view_changed = pyqtSignal()

    def __init__(self, scene: Scene, parent: QWidget | None = None):
        super().__init__(parent)
        self.scene = scene
        self.setMinimumSize(320, 240)
        self.setMouseTracking(True)
        self.setAttribute(Qt.WA_OpaquePaintEvent)
        self.paint_seconds = 0.0
        self._is_fitted = True
        self._held_car: tuple[float, float] | None = None  # where the mouse holds the car [u]
        self._press: QPoint | None = None
        self._last_mouse = QPoint()
        self._is_panning = False
        self._ground = self._ground_key = None
        self._points = self._points_key = None
        self._polygons: dict[int, tuple[list, QPolygonF]] = {}
        self._labelled: set[Point] = set()
        self.view = fit([], 320, 240, MARGIN_PIXELS)

    # View
    def fit_view(self) -> None:
        """Show the whole field, also after the size of the window or of the field changes."""
        self._is_fitted = True
        self._refit()

    def zoom(
        self, factor: float, pixel_x: float | None = None, pixel_y: float | None = None
    ) -> None:
        """Scale the view by `factor` around a pixel, by default the middle of the widget."""
        x = self.width() / 2.0 if pixel_x is None else pixel_x
        y = self.height() / 2.0 if pixel_y is None else pixel_y
        self._is_fitted = False
        self.view = self.view.zoomed(factor, x, y)
        self.view_changed.emit()

    def _refit(self) -> None:
        view = fit(self.scene.corners(), self.width(), self.height(), MARGIN_PIXELS)
        if view != self.view:
            self.view = view
            self.view_changed.emit()

    def resizeEvent(self, _event: QResizeEvent) -> None:  # noqa: N802 (Qt's name)
        """Keep the centre of the view in the middle of the widget."""
        self.view = self.view._replace(width=self.width(), height=self.height())
        if self._is_fitted:
            self._refit()

    # Mouse
    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Grab the car, or begin a click or a pan."""
        self._press = self._last_mouse = event.pos()
        self._is_panning = event.button() != Qt.LeftButton
        if event.button() == Qt.LeftButton and self._is_over_car(event.pos()):
            self._held_car = self._field_point(event.pos())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Carry the car or pan, and set the cursor that shows what a press does here."""
        if self._held_car is not None:
            self._held_car = self._field_point(event.pos())
            self.car_dragged.emit(*self._held_car)
        elif self._press is not None:
            self._is_panning = (
                self._is_panning or (event.pos() - self._press).manhattanLength() > CLICK_PIXELS
            )
            if self._is_panning:
                moved = event.pos() - self._last_mouse
                self._is_fitted = False
                self.view = self.view.panned(moved.x(), moved.y())
        self._last_mouse = event.pos()
        over = self._held_car is not None or self._is_over_car(event.pos())
        self.setCursor(Qt.OpenHandCursor if over else Qt.CrossCursor)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Release the car, or end a click and request a waypoint there."""
        if self._held_car is not None:
            self.car_dragged.emit(*self._field_point(event.pos()))
        elif self._press is not None and not self._is_panning:
            x, y = self._field_point(event.pos())
            if self.scene.contains(x, y):
                self.waypoint_requested.emit(x, y)
            else:
                self.click_refused.emit(
                    "That is outside the walls: click inside to add a waypoint."
                )
        self._held_car = self._press = None
        self._is_panning = False

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 (Qt's name)
        """Zoom around the mouse."""
        position = event.position() if hasattr(event, "position") else QPointF(event.pos())
        self.zoom(ZOOM_STEP ** (event.angleDelta().y() / 120.0), position.x(), position.y())

    def hold_car(self) -> None:
        """Emit the position of a held car again, so that it does not drive away from the mouse."""
        if self._held_car is not None:
            self.car_dragged.emit(*self._held_car)

    def _field_point(self, pixel: QPoint) -> tuple[float, float]:
        return self.view.to_field(pixel.x(), pixel.y())

    def _is_over_car(self, pixel: QPoint) -> bool:
        car = self.scene.car_at(time.monotonic())
        if car is None:
            return False
        x, y = self.view.to_pixel(car.x, car.y)
        reach = max(GRAB_PIXELS, 0.7 * self.scene.car_size * self.view.scale)
        return math.hypot(pixel.x() - x, pixel.y() - y) <= reach

    # Painting
    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Draw a frame: still items from cached pictures, then the moving items."""
        begin = time.perf_counter()
        if self._is_fitted:
            self._refit()
        painter = QPainter(self)
        painting.start(painter)
        painter.drawPixmap(0, 0, self._ground_picture())
        car = self._shown_car()
        self._paint_newest_trail(painter, car)
        painter.drawPixmap(0, 0, self._points_picture())
        self._paint_moving(painter, car)
        painter.end()
        self.paint_seconds = time.perf_counter() - begin

    def _ground_picture(self) -> QPixmap:
        """Return floor, walls and finished trail; draw them again only after a change."""
        key = (self.view, self.scene.version, self.scene.trail.version)
        if key != self._ground_key:
            picture = self._new_picture()
            painter = QPainter(picture)
            painting.start(painter)
            sizes = self.scene.sizes
            walls = (sizes.field_width, sizes.field_height) if self.scene.has_walls else None
            painting.floor(painter, self.view, walls, nice_step(GRID_PIXELS / self.view.scale))
            self._paint_finished_trail(painter)
            painter.end()
            self._ground, self._ground_key = picture, key
        return self._ground

    def _paint_finished_trail(self, painter: QPainter) -> None:
        """Draw the finished pieces of trail, older ones fainter; cache their polygons."""
        pieces = self.scene.trail.finished
        kept = {}
        for index, piece in enumerate(pieces):
            # The cache holds the piece too: the id of a deleted list could return with another one.
            _, polygon = self._polygons.get(id(piece)) or (
                piece,
                QPolygonF([QPointF(*point) for point in piece]),
            )
            kept[id(piece)] = piece, polygon
            freshness = 1.0 - (len(pieces) - index) / max(len(pieces) + 1.0, FADE_PIECES)
            self._paint_polyline(painter, polygon, freshness)
        self._polygons = kept

    def _points_picture(self) -> QPixmap:
        """Return the waypoints, with numbers where these do not overlap."""
        key = (self.view, self.scene.version)
        if key != self._points_key:
            picture = self._new_picture()
            picture.fill(Qt.transparent)
            painter = QPainter(picture)
            painting.start(painter)
            self._labelled = labelled_points(self.scene.waypoints, self.view)
            for point in self.scene.waypoints:
                self._paint_disc(painter, point, painting.WAYPOINT)
            painter.end()
            self._points, self._points_key = picture, key
        return self._points

    def _new_picture(self) -> QPixmap:
        ratio = self.devicePixelRatioF()
        picture = QPixmap(max(1, round(self.width() * ratio)), max(1, round(self.height() * ratio)))
        picture.setDevicePixelRatio(ratio)
        return picture

    def _paint_polyline(self, painter: QPainter, polygon: QPolygonF, freshness: float) -> None:
        x, y = self.view.to_pixel(0.0, 0.0)
        painter.save()
        painter.setTransform(QTransform(self.view.scale, 0.0, 0.0, -self.view.scale, x, y), True)
        painter.setPen(painting.trail_pen(freshness))
        painter.drawPolyline(polygon)
        painter.restore()

    def _radius(self, point: Point) -> float:
        return painting.DISC_RADIUS if point in self._labelled else painting.DOT_RADIUS

    def _paint_disc(self, painter: QPainter, point: Point, colour: QColor) -> None:
        x, y = self.view.to_pixel(point.x, point.y)
        number = str(point.idx) if point in self._labelled else ""
        painting.disc(painter, x, y, self._radius(point), colour, number)

    def _shown_car(self) -> Pose | None:
        car = self.scene.car_at(time.monotonic())
        if car is not None and self._held_car is not None:
            car = car._replace(x=self._held_car[0], y=self._held_car[1])
        return car

    def _paint_newest_trail(self, painter: QPainter, car: Pose | None) -> None:
        """Draw the growing piece of trail, up to the position at which the car is drawn."""
        points = self.scene.trail.growing[:-1] + ([(car.x, car.y)] if car is not None else [])
        self._paint_polyline(painter, QPolygonF([QPointF(*point) for point in points]), 1.0)

    def _paint_moving(self, painter: QPainter, car: Pose | None) -> None:
        scene = self.scene
        if car is not None and scene.sizes.sensor_range:
            self._paint_sensor(painter, car)
        for point in sorted(scene.sensed):
            painting.glow(painter, *self.view.to_pixel(point.x, point.y), self._radius(point))
            self._paint_disc(painter, point, painting.SENSED)
        if scene.target is not None:
            painting.ring(
                painter,
                *self.view.to_pixel(scene.target.x, scene.target.y),
                self._radius(scene.target),
            )
        if car is not None:
            x, y = self.view.to_pixel(car.x, car.y)
            painting.car(painter, x, y, max(scene.car_size * self.view.scale, 8.0), car.direction)
        if scene.is_paused:
            painter.setFont(painting.number_font(30.0))
            painter.setPen(painting.FAINT_INK)
            painter.drawText(QRectF(0, 0, self.width(), 80), Qt.AlignCenter, "paused")

    def _paint_sensor(self, painter: QPainter, car: Pose) -> None:
        """Draw the range of the sensor, inside the walls only."""
        sizes = self.scene.sizes
        x, y = self.view.to_pixel(car.x, car.y)
        painter.save()
        if self.scene.has_walls:
            half_width, half_height = sizes.field_width / 2.0, sizes.field_height / 2.0
            top_left = QPointF(*self.view.to_pixel(-half_width, half_height))
            bottom_right = QPointF(*self.view.to_pixel(half_width, -half_height))
            painter.setClipRect(QRectF(top_left, bottom_right))
        radius = sizes.sensor_range * self.view.scale
        painting.sensor(painter, x, y, radius, car.direction, sizes.sensor_front_only)
        painter.restore()
