"""The field on the screen: draw the scene, and convert mouse and wheel events into signals."""

from __future__ import annotations

import math
import time
from typing import Callable, Iterable, Sequence

from PyQt5.QtCore import QPoint, QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import (
    QColor,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPixmap,
    QResizeEvent,
    QTransform,
    QWheelEvent,
)
from PyQt5.QtWidgets import QWidget

from qt_interface import painting
from qt_interface.scene import PIECE, Point, Pose, Scene

CLICK_PIXELS = 4  # a press that moves at most this far is a click
GRAB_PIXELS = 14  # smallest distance from its centre at which the car can be grabbed
MARGIN_PIXELS = 30  # around the field when all of it is visible
ZOOM_STEP = 1.15  # of one notch of the wheel
FADE_PIECES = 16  # a trail with fewer pieces does not fade completely
LABEL_PIXELS = 24  # smallest distance of two numbered waypoints
SCALE_MIN, SCALE_MAX = 0.02, 40.0  # pixels per field unit


def fit(points: Sequence[tuple[float, float]], width: int, height: int) -> QTransform:
    """Return the transformation from field units to pixels that shows all points.

    On the field y points up, on the screen down.

    Args:
        points: field points (x, y) [u]
        width: width of the widget [pixels]
        height: height of the widget [pixels]
    """
    xs, ys = [x for x, _ in points] or [0.0], [y for _, y in points] or [0.0]
    room_x, room_y = max(width - 2 * MARGIN_PIXELS, 1), max(height - 2 * MARGIN_PIXELS, 1)
    scale = min(room_x / max(max(xs) - min(xs), 1.0), room_y / max(max(ys) - min(ys), 1.0))
    scale = min(max(scale, SCALE_MIN), SCALE_MAX)
    view = QTransform.fromTranslate(width / 2.0, height / 2.0).scale(scale, -scale)
    return view.translate(-0.5 * (min(xs) + max(xs)), -0.5 * (min(ys) + max(ys)))


def labelled_points(waypoints: Iterable[Point], view: QTransform) -> set[Point]:
    """Return the waypoints that have room for a number; earlier waypoints have priority."""
    taken: dict[tuple[int, int], list[tuple[float, float]]] = {}
    labelled = set()
    for point in waypoints:
        pixel = view.map(point.x, point.y)
        column, row = (math.floor(value / LABEL_PIXELS) for value in pixel)
        neighbours = [(column + i, row + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        near = [other for cell in neighbours for other in taken.get(cell, ())]
        if all(math.dist(pixel, other) >= LABEL_PIXELS for other in near):
            taken.setdefault((column, row), []).append(pixel)
            labelled.add(point)
    return labelled


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
        self.view = fit([], 320, 240)
        self.held_car: tuple[float, float] | None = None  # where the mouse holds the car [u]
        self._is_fitted = True
        self._press: QPoint | None = None
        self._last_mouse = QPoint()
        self._is_panning = False
        self._pictures: dict[str, tuple[tuple, QPixmap]] = {}
        self._labelled: set[Point] = set()

    # View
    def fit_view(self) -> None:
        """Show the whole field, also after the size of the window or of the field changes."""
        self._is_fitted = True
        self.view = fit(self.scene.corners(), self.width(), self.height())

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
        """Draw a frame: still items from cached pictures, then the moving items."""
        if self._is_fitted:
            self.fit_view()
        scene = self.scene
        car = scene.car_at(time.monotonic())
        if car is not None and self.held_car is not None:
            car = car._replace(x=self.held_car[0], y=self.held_car[1])
        painter = QPainter(self)
        painting.start(painter)
        view_key = (self.view, self.width(), self.height(), scene.version)
        ground_key = (*view_key, scene.trail_count // PIECE)
        painter.drawPixmap(0, 0, self._picture("ground", ground_key, self._paint_ground))
        # The newest piece of the trail ends at the position at which the car is drawn.
        end = [(car.x, car.y)] if car is not None else []
        self._paint_trail(painter, scene.newest_trail()[:-1] + end, 1.0)
        painter.drawPixmap(0, 0, self._picture("points", view_key, self._paint_points))
        self._paint_moving(painter, car)
        painter.end()

    def _picture(self, name: str, key: tuple, paint: Callable[[QPainter], None]) -> QPixmap:
        """Return a picture of still items; draw it again only after `key` changed."""
        if name not in self._pictures or self._pictures[name][0] != key:
            ratio = self.devicePixelRatioF()
            picture = QPixmap(round(self.width() * ratio), round(self.height() * ratio))
            picture.setDevicePixelRatio(ratio)
            picture.fill(Qt.transparent)
            painter = QPainter(picture)
            painting.start(painter)
            paint(painter)
            painter.end()
            self._pictures[name] = key, picture
        return self._pictures[name][1]

    def _paint_ground(self, painter: QPainter) -> None:
        """Draw floor, walls and the finished pieces of the trail, older ones fainter."""
        painting.floor(painter, self.view, QRectF(self.rect()), self._walls())
        pieces = self.scene.trail_pieces()
        for index, piece in enumerate(pieces):
            freshness = 1.0 - (len(pieces) - index) / max(len(pieces) + 1.0, FADE_PIECES)
            self._paint_trail(painter, piece, freshness)

    def _walls(self) -> QRectF | None:
        """Return the field in pixels, or None if it has no walls."""
        if self.scene.walls is None:
            return None
        x, y = self.scene.walls
        return self.view.mapRect(QRectF(-x, -y, 2.0 * x, 2.0 * y))

    def _paint_points(self, painter: QPainter) -> None:
        """Draw the waypoints, with numbers where these do not overlap."""
        self._labelled = labelled_points(self.scene.waypoints, self.view)
        for point in self.scene.waypoints:
            self._paint_disc(painter, point, painting.WAYPOINT)

    def _paint_trail(
        self, painter: QPainter, points: list[tuple[float, float]], freshness: float
    ) -> None:
        pixels = [self.view.map(*point) for point in points]
        painting.trail(painter, pixels, self.scene.settings.trail_jump * self.scale, freshness)

    def _radius(self, point: Point) -> float:
        return painting.DISC_RADIUS if point in self._labelled else painting.DOT_RADIUS

    def _paint_disc(self, painter: QPainter, point: Point, colour: QColor) -> None:
        x, y = self.view.map(point.x, point.y)
        number = str(point.idx) if point in self._labelled else ""
        painting.disc(painter, x, y, self._radius(point), colour, number)

    def _paint_moving(self, painter: QPainter, car: Pose | None) -> None:
        scene = self.scene
        if car is not None and scene.sizes.sensor_range:
            self._paint_sensor(painter, car)
        for point in scene.sensed:
            painting.glow(painter, *self.view.map(point.x, point.y), self._radius(point))
            self._paint_disc(painter, point, painting.SENSED)
        if scene.target is not None:
            x, y = self.view.map(scene.target.x, scene.target.y)
            painting.ring(painter, x, y, self._radius(scene.target))
        if car is not None:
            x, y = self.view.map(car.x, car.y)
            painting.car(painter, x, y, max(scene.car_size * self.scale, 8.0), car.direction)
        if scene.is_paused:
            painter.setFont(painting.font(32, is_bold=True))
            painter.setPen(painting.FAINT_INK)
            painter.drawText(QRectF(0, 0, self.width(), 80), Qt.AlignCenter, "paused")

    def _paint_sensor(self, painter: QPainter, car: Pose) -> None:
        """Draw the range of the sensor, inside the walls only."""
        sizes = self.scene.sizes
        x, y = self.view.map(car.x, car.y)
        painter.save()
        painter.setClipRect(self._walls() or QRectF(self.rect()))
        radius = sizes.sensor_range * self.scale
        painting.sensor(painter, x, y, radius, car.direction, sizes.sensor_front_only)
        painter.restore()
