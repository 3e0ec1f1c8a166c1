"""The field on the screen: a view of graphics items that the mouse drags, pans and zooms."""

from __future__ import annotations

import math
from collections import deque
from types import SimpleNamespace
from typing import Iterable, NamedTuple

from PyQt5.QtCore import QLineF, QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import (
    QColor,
    QFont,
    QMouseEvent,
    QPainter,
    QPen,
    QPolygonF,
    QResizeEvent,
    QWheelEvent,
)
from PyQt5.QtWidgets import QGraphicsEllipseItem as Ellipse
from PyQt5.QtWidgets import QGraphicsItem, QGraphicsScene, QGraphicsView
from PyQt5.QtWidgets import QGraphicsLineItem as Line
from PyQt5.QtWidgets import QGraphicsPolygonItem as Polygon
from PyQt5.QtWidgets import QGraphicsRectItem as Rectangle
from PyQt5.QtWidgets import QGraphicsSimpleTextItem as Text

from qt_interface.settings import WorldSizes

GROUND = QColor("#e9edf1")
FLOOR = QColor("#fdfdfb")
GRID = QColor("#edf0f2")
WALL = QColor("#3b4754")
INK = QColor("#26313c")
FAINT_INK = QColor("#74818e")
WAYPOINT = QColor("#6d8196")
SENSED = QColor("#f0a202")
TARGET = QColor("#1769d2")
SENSOR = QColor("#2a9d6f")
CAR = QColor("#e02f2f")
CAR_EDGE = QColor("#8e1414")

DISC_RADIUS = 11.0  # pixels, of a waypoint with a number
DOT_RADIUS = 4.0  # pixels, of the waypoints if they are too many for numbers
MAX_NUMBERED = 300
MIN_CAR_PIXELS = 8.0  # the car is drawn at least this large
CLICK_PIXELS = 4  # a press that moves at most this far is a click
GRID_SQUARES = 16  # from wall to wall
FADE_PIECES = 16  # the trail fades in so many steps
ZOOM_STEP = 1.15  # of one notch of the wheel
ZOOM_MIN, ZOOM_MAX = 0.02, 40.0  # pixels per field unit
LARGEST_COORDINATE = 1e7  # u, the mouse can pan so far


class Point(NamedTuple):
    """A waypoint with its number, at `x`, `y` [u]."""

    idx: int
    x: float
    y: float


def _pen(colour: QColor, pixels: float, style: Qt.PenStyle = Qt.SolidLine) -> QPen:
    """Return a pen whose width does not depend on the zoom."""
    pen = QPen(colour, pixels, style, Qt.FlatCap, Qt.MiterJoin)
    pen.setCosmetic(True)
    return pen


def _faint(colour: QColor, alpha: float) -> QColor:
    return QColor.fromRgbF(colour.redF(), colour.greenF(), colour.blueF(), alpha)


def _bold(pixels: int) -> QFont:
    font = QFont("DejaVu Sans", weight=QFont.Bold)
    font.setPixelSize(pixels)
    return font


def _disc(point: Point, radius: float, colour: QColor, edge: QPen) -> Ellipse:
    """Return a disc at a point, whose radius [pixels] does not depend on the zoom."""
    disc = Ellipse(-radius, -radius, 2.0 * radius, 2.0 * radius)
    disc.setFlag(QGraphicsItem.ItemIgnoresTransformations)
    disc.setPos(point.x, point.y)
    disc.setBrush(colour)
    disc.setPen(edge)
    return disc


def _car() -> Rectangle:
    """Return a car of 1 x 1 u at the origin, with an arrow in its direction, +x."""
    car = Rectangle(-0.5, -0.5, 1.0, 1.0)
    car.setBrush(CAR)
    car.setPen(_pen(CAR_EDGE, 1.5))
    car.setFlag(QGraphicsItem.ItemIsMovable)
    car.setCursor(Qt.PointingHandCursor)
    car.setZValue(2.0)
    Line(0.5, 0.0, 1.05, 0.0, car).setPen(_pen(CAR_EDGE, 1.5))
    corners = ((0.34, 0.0), (-0.2, 0.28), (-0.06, 0.0), (-0.2, -0.28))
    arrow = Polygon(QPolygonF([QPointF(x, y) for x, y in corners]), car)
    arrow.setBrush(Qt.white)
    arrow.setPen(QPen(Qt.NoPen))
    return car


class Field(QGraphicsView):
    """A view of the field; its signals carry field units, and the mouse changes only the view."""

    car_dragged = pyqtSignal(float, float)
    waypoint_requested = pyqtSignal(float, float)
    click_refused = pyqtSignal(str)

    def __init__(self, settings: SimpleNamespace):
        """Create an empty field; `settings` are those of `qt_interface.settings`."""
        super().__init__()
        self.setMinimumSize(320, 240)
        self.setRenderHint(QPainter.Antialiasing)
        self.setDragMode(QGraphicsView.ScrollHandDrag)
        self.setTransformationAnchor(QGraphicsView.AnchorUnderMouse)
        self.setResizeAnchor(QGraphicsView.AnchorViewCenter)
        self.setViewportUpdateMode(QGraphicsView.NoViewportUpdate)  # the window draws each frame
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarAlwaysOff)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarAlwaysOff)
        self.setFrameStyle(0)
        self.scale(1.0, -1.0)  # on the field y points up, on the screen down
        reach = LARGEST_COORDINATE
        self.setScene(QGraphicsScene(-reach, -reach, 2.0 * reach, 2.0 * reach, self))
        self.settings = settings
        self.sizes = WorldSizes()
        self.waypoints: list[Point] = []
        self.sensed: list[Point] = []
        self.target: Point | None = None
        self.pose: tuple[float, float, float] | None = None  # x, y [u], direction [rad]
        self.is_paused = False
        self.trail: deque[QLineF] = deque(maxlen=settings.trail_points)  # steps of the car
        self._discs: dict[str, list[QGraphicsItem]] = {}  # by the name of their colour
        self._is_fitted = True
        self._press = QPointF()

        self.sensor = Ellipse()
        self.sensor.setBrush(_faint(SENSOR, 0.1))
        self.sensor.setPen(_pen(SENSOR, 1.5, Qt.DashLine))
        self.car = _car()
        for item in (self.sensor, self.car):
            item.hide()
            self.scene().addItem(item)

    @property
    def walls(self) -> QRectF | None:
        """The field around the origin [u]; None if the world does not set its size."""
        width, height = self.sizes.field_width, self.sizes.field_height
        if width is None or height is None:
            return None
        return QRectF(-width / 2.0, -height / 2.0, width, height)

    # New data
    def set_world(self, sizes: WorldSizes, points: Iterable[Point]) -> None:
        """Set the world's sizes and the waypoints; ignore non-finite points."""
        self.sizes = sizes
        self.waypoints = self._show(points, WAYPOINT, Qt.white, _pen(Qt.white, 1.5))
        reach = sizes.sensor_range or 0.0
        self.sensor.setRect(-reach, -reach, 2.0 * reach, 2.0 * reach)
        self.sensor.setStartAngle(-90 * 16)
        self.sensor.setSpanAngle((180 if sizes.sensor_front_only else 360) * 16)

    def set_sensed(self, points: Iterable[Point]) -> None:
        """Set the points that the sensor detects now."""
        self.sensed = self._show(set(points), SENSED, INK, _pen(_faint(SENSED, 0.3), 9.0))

    def set_target(self, point: Point) -> None:
        """Set the driver's target; remove it if the point is not finite."""
        self.target = point if math.isfinite(point.x + point.y) else None
        rings = [_disc(point, DISC_RADIUS + 5.0, Qt.transparent, _pen(TARGET, 3.0))]
        self._replace(TARGET, rings if self.target else [])

    def _show(self, given: Iterable[Point], colour: QColor, ink: QColor, edge: QPen) -> list[Point]:
        """Show numbered discs in place of the earlier ones of this colour; return their points."""
        points = sorted(point for point in given if math.isfinite(point.x + point.y))
        has_numbers = len(points) <= MAX_NUMBERED
        discs = []
        for point in points:
            disc = _disc(point, DISC_RADIUS if has_numbers else DOT_RADIUS, colour, edge)
            if has_numbers:
                number = Text(str(point.idx), disc)
                number.setFont(_bold(12 if point.idx < 100 else 8))
                number.setBrush(ink)
                number.setPos(-number.boundingRect().center())
            discs.append(disc)
        self._replace(colour, discs)
        return points

    def _replace(self, colour: QColor, discs: list[QGraphicsItem]) -> None:
        for disc in self._discs.get(colour.name(), ()):
            self.scene().removeItem(disc)
        self._discs[colour.name()] = discs
        for disc in discs:
            disc.setZValue(0.0 if colour is WAYPOINT else 1.0)
            self.scene().addItem(disc)

    def set_car(self, x: float, y: float, direction: float) -> None:
        """Set the car's position [u] and direction [rad]; ignore a pose that is not finite."""
        if not all(map(math.isfinite, (x, y, direction))):
            return
        if self.pose is not None:
            step = QLineF(*self.pose[:2], x, y)
            if step.length() <= self.settings.trail_jump:
                self.trail.append(step)
        self.pose = x, y, direction
        if not self.is_car_held:
            self.car.setPos(x, y)
        for item in (self.car, self.sensor):
            item.setRotation(math.degrees(direction))
            item.show()

    # View
    @property
    def zoom(self) -> float:
        """Pixels per field unit."""
        return self.transform().m11()

    def zoom_by(self, factor: float) -> None:
        """Scale the view around the mouse."""
        self._is_fitted = False
        factor = min(max(factor, ZOOM_MIN / self.zoom), ZOOM_MAX / self.zoom)
        self.scale(factor, factor)

    def fit_view(self) -> None:
        """Show the whole field, also after the size of the window or of the field changes."""
        self._is_fitted = True
        area = self.extent()
        margin = 0.0375 * max(area.width(), area.height(), 1.0)
        self.fitInView(area.adjusted(-margin, -margin, margin, margin), Qt.KeepAspectRatio)

    def extent(self) -> QRectF:
        """Return the area [u] that a view of everything must contain."""
        points = [QPointF(point.x, point.y) for point in self.waypoints]
        if self.walls is None:
            points += [end for step in self.trail for end in (step.p1(), step.p2())]
            points += [QPointF(*self.pose[:2])] if self.pose else []
        else:
            points += [self.walls.topLeft(), self.walls.bottomRight()]
        return QPolygonF(points).boundingRect()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 (Qt's name)
        """Keep the whole field in view, if it was."""
        super().resizeEvent(event)
        if self._is_fitted:
            self.fit_view()

    def next_frame(self) -> None:
        """Draw everything again; report a held car again, so that it does not drive away."""
        if self._is_fitted:
            self.fit_view()
        self.car.setScale(
            max(self.sizes.car_size or self.settings.plain_car_size, MIN_CAR_PIXELS / self.zoom)
        )
        self.sensor.setPos(self.car.pos())
        if self.is_car_held:
            self.car_dragged.emit(self.car.x(), self.car.y())
        self.viewport().update()

    # Mouse
    @property
    def is_car_held(self) -> bool:
        """Whether the mouse holds the car."""
        return self.scene().mouseGrabberItem() is self.car

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 (Qt's name)
        """Zoom around the mouse."""
        self.zoom_by(ZOOM_STEP ** (event.angleDelta().y() / 120.0))

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Grab the car, or begin a click or a pan."""
        self._press = event.pos()
        super().mousePressEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Carry the car, or pan."""
        self._is_fitted &= not event.buttons() or self.is_car_held
        super().mouseMoveEvent(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Release the car, or end a click and request a waypoint there."""
        was_car_held = self.is_car_held
        super().mouseReleaseEvent(event)
        if was_car_held:
            self.car_dragged.emit(self.car.x(), self.car.y())
        elif (
            event.button() == Qt.LeftButton
            and (event.pos() - self._press).manhattanLength() <= CLICK_PIXELS
        ):
            point = self.mapToScene(event.pos())
            if self.walls is None or self.walls.contains(point):
                self.waypoint_requested.emit(point.x(), point.y())
            else:
                self.click_refused.emit(
                    "That is outside the walls: click inside to add a waypoint."
                )

    # Painting
    def drawBackground(self, painter: QPainter, rect: QRectF) -> None:  # noqa: N802 (Qt's name)
        """Draw the floor with its grid and walls, and the trail."""
        painter.fillRect(rect, GROUND)
        walls = self.walls
        if walls is not None:
            half = 3.0 / self.zoom
            painter.setBrush(FLOOR)
            painter.setPen(_pen(WALL, 6.0))
            painter.drawRect(walls.adjusted(-half, -half, half, half))
            painter.setPen(_pen(GRID, 1.0))
            step = walls.width() / GRID_SQUARES
            for i in range(-GRID_SQUARES // 2, GRID_SQUARES // 2 + 1):
                painter.drawLine(QLineF(i * step, walls.top(), i * step, walls.bottom()))
            rows = int(walls.bottom() / step)
            for i in range(-rows, rows + 1):
                painter.drawLine(QLineF(walls.left(), i * step, walls.right(), i * step))
        # The trail, older pieces fainter
        steps = list(self.trail)
        length = max(math.ceil(len(steps) / FADE_PIECES), 100)
        for age, end in enumerate(range(len(steps), 0, -length)):
            painter.setPen(_pen(_faint(CAR, 0.06 + 0.54 * (1.0 - age / FADE_PIECES) ** 2), 2.0))
            painter.setRenderHint(QPainter.Antialiasing, age == 0)  # it takes three times as long
            painter.drawLines(steps[max(end - length, 0) : end])
        painter.setRenderHint(QPainter.Antialiasing)

    def drawForeground(self, painter: QPainter, _rect: QRectF) -> None:  # noqa: N802 (Qt's name)
        """Write that the world is paused."""
        if self.is_paused:
            painter.resetTransform()
            painter.setFont(_bold(32))
            painter.setPen(FAINT_INK)
            painter.drawText(QRectF(0, 0, self.width(), 80), Qt.AlignCenter, "paused")
