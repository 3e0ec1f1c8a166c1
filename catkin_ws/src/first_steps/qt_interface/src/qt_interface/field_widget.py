"""The field on the screen: draws the scene, and turns mouse and wheel into wishes."""

from __future__ import annotations

import math
import time

from PyQt5.QtCore import QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import QPainter, QPixmap, QPolygonF, QTransform
from PyQt5.QtWidgets import QWidget

from qt_interface import painting
from qt_interface.view import fit, nice_step

CLICK_PIXELS = 4  # a press that moves no farther than this is a click
GRAB_PIXELS = 14  # the car can be grabbed at least this far from its centre
MARGIN_PIXELS = 30  # around the field when all of it is shown
ZOOM_STEP = 1.15  # of one notch of the wheel
GRID_PIXELS = 60  # at most between two lines of the grid
FADE_PIECES = 16  # a trail of fewer pieces has not faded to the end yet
LABEL_PIXELS = 24  # at least between two numbered waypoints


def labelled_points(waypoints, view):
    """The waypoints on the widget that have room for a number; the first come are the first served."""
    taken, labelled = {}, set()
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
    """Shows a Scene. Signals carry field units; it changes nothing itself but its view."""

    car_dragged = pyqtSignal(float, float)
    waypoint_wished = pyqtSignal(float, float)
    click_refused = pyqtSignal(str)
    view_changed = pyqtSignal()

    def __init__(self, scene, parent=None):
        super().__init__(parent)
        self.scene = scene
        self.setMinimumSize(320, 240)
        self.setMouseTracking(True)
        self.setAttribute(Qt.WA_OpaquePaintEvent)
        self.paint_seconds = 0.0
        self._is_fitted = True
        self._held_car = None  # where the mouse holds the car, field units
        self._press = None  # where the mouse was pressed, and where it was last
        self._last_mouse = None
        self._is_panning = False
        self._ground = self._ground_key = None
        self._points = self._points_key = None
        self._polygons = {}
        self._labelled = set()  # waypoints with room for a number
        self.view = fit([], 320, 240, MARGIN_PIXELS)

    # View
    def fit_view(self):
        """Shows all of the field, and keeps showing it when the window's size or the field changes."""
        self._is_fitted = True
        self._refit()

    def zoom(self, factor, pixel_x=None, pixel_y=None):
        """Zooms around a pixel, the middle by default."""
        x = self.width() / 2.0 if pixel_x is None else pixel_x
        y = self.height() / 2.0 if pixel_y is None else pixel_y
        self._is_fitted = False
        self.view = self.view.zoomed(factor, x, y)
        self.view_changed.emit()

    def _refit(self):
        view = fit(self.scene.corners(), self.width(), self.height(), MARGIN_PIXELS)
        if view != self.view:
            self.view = view
            self.view_changed.emit()

    def resizeEvent(self, _event):  # noqa: N802 (Qt's name)
        """Keeps the middle of the view in the middle."""
        self.view = self.view._replace(width=self.width(), height=self.height())
        if self._is_fitted:
            self._refit()

    # Mouse
    def mousePressEvent(self, event):  # noqa: N802 (Qt's name)
        """Grabs the car, or begins a click or a pan."""
        self._press = self._last_mouse = event.pos()
        self._is_panning = event.button() != Qt.LeftButton
        if event.button() == Qt.LeftButton and self._is_over_car(event.pos()):
            self._held_car = self._field_point(event.pos())

    def mouseMoveEvent(self, event):  # noqa: N802 (Qt's name)
        """Carries the car, or pans; shows by the cursor what a press would do."""
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

    def mouseReleaseEvent(self, event):  # noqa: N802 (Qt's name)
        """Lets go of the car, or ends a click: a wish for a waypoint there."""
        if self._held_car is not None:
            self.car_dragged.emit(*self._field_point(event.pos()))
        elif self._press is not None and not self._is_panning:
            x, y = self._field_point(event.pos())
            if self.scene.contains(x, y):
                self.waypoint_wished.emit(x, y)
            else:
                self.click_refused.emit(
                    "That is outside the walls: click inside to add a waypoint."
                )
        self._held_car = self._press = None
        self._is_panning = False

    def wheelEvent(self, event):  # noqa: N802 (Qt's name)
        """Zooms around the mouse."""
        position = event.position() if hasattr(event, "position") else QPointF(event.pos())
        self.zoom(ZOOM_STEP ** (event.angleDelta().y() / 120.0), position.x(), position.y())

    def hold_car(self):
        """While the mouse holds the car, says so again, so that it does not drive away below the mouse."""
        if self._held_car is not None:
            self.car_dragged.emit(*self._held_car)

    def _field_point(self, pixel):
        return self.view.to_field(pixel.x(), pixel.y())

    def _is_over_car(self, pixel):
        car = self.scene.car_at(time.monotonic())
        if car is None:
            return False
        x, y = self.view.to_pixel(car.x, car.y)
        reach = max(GRAB_PIXELS, 0.7 * self.scene.car_size * self.view.scale)
        return math.hypot(pixel.x() - x, pixel.y() - y) <= reach

    # Painting
    def paintEvent(self, _event):  # noqa: N802 (Qt's name)
        """Draws a frame: ground and old trail from a picture kept, what moves anew."""
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

    def _ground_picture(self):
        """Floor, walls and the trail but its newest piece; drawn anew when the view or one of them changed."""
        key = (self.view, self.scene.version, self.scene.trail.version)
        if key != self._ground_key:
            picture = self._new_picture()
            painter = QPainter(picture)
            painting.start(painter)
            sizes = self.scene.sizes
            walls = (sizes.field_width, sizes.field_height) if self.scene.has_walls else None
            painting.floor(painter, self.view, walls, nice_step(GRID_PIXELS / self.view.scale))
            self._paint_old_trail(painter)
            painter.end()
            self._ground, self._ground_key = picture, key
        return self._ground

    def _paint_old_trail(self, painter):
        """The finished pieces of trail, the fainter the older; their polygons are kept, and with them the pieces."""
        pieces = self.scene.trail.finished
        kept = {}
        for place, piece in enumerate(pieces):
            _, polygon = self._polygons.get(id(piece)) or (
                piece,
                QPolygonF([QPointF(*point) for point in piece]),
            )
            kept[id(piece)] = piece, polygon
            freshness = 1.0 - (len(pieces) - place) / max(len(pieces) + 1.0, FADE_PIECES)
            self._paint_polyline(painter, polygon, freshness)
        self._polygons = kept

    def _points_picture(self):
        """The waypoints, over the trail; numbers only where they do not cover one another."""
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

    def _new_picture(self):
        ratio = self.devicePixelRatioF()
        picture = QPixmap(max(1, round(self.width() * ratio)), max(1, round(self.height() * ratio)))
        picture.setDevicePixelRatio(ratio)
        return picture

    def _paint_polyline(self, painter, polygon, freshness):
        x, y = self.view.to_pixel(0.0, 0.0)
        painter.save()
        painter.setTransform(QTransform(self.view.scale, 0.0, 0.0, -self.view.scale, x, y), True)
        painter.setPen(painting.trail_pen(freshness))
        painter.drawPolyline(polygon)
        painter.restore()

    def _radius(self, point):
        return painting.DISC_RADIUS if point in self._labelled else painting.DOT_RADIUS

    def _paint_disc(self, painter, point, colour):
        x, y = self.view.to_pixel(point.x, point.y)
        number = str(point.idx) if point in self._labelled else ""
        painting.disc(painter, x, y, self._radius(point), colour, number)

    def _shown_car(self):
        car = self.scene.car_at(time.monotonic())
        if car is not None and self._held_car is not None:
            car = car._replace(x=self._held_car[0], y=self._held_car[1])
        return car

    def _paint_newest_trail(self, painter, car):
        """The piece of trail that still grows, up to where the car is drawn."""
        points = self.scene.trail.growing[:-1] + ([(car.x, car.y)] if car is not None else [])
        self._paint_polyline(painter, QPolygonF([QPointF(*point) for point in points]), 1.0)

    def _paint_moving(self, painter, car):
        scene = self.scene
        if car is not None and scene.sizes.sensor_range:
            x, y = self.view.to_pixel(car.x, car.y)
            painter.save()
            if scene.has_walls:
                half_width, half_height = (
                    scene.sizes.field_width / 2.0,
                    scene.sizes.field_height / 2.0,
                )
                painter.setClipRect(
                    QRectF(
                        QPointF(*self.view.to_pixel(-half_width, half_height)),
                        QPointF(*self.view.to_pixel(half_width, -half_height)),
                    )
                )
            painting.sensor(
                painter,
                x,
                y,
                scene.sizes.sensor_range * self.view.scale,
                car.direction,
                scene.sizes.sensor_front_only,
            )
            painter.restore()
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
