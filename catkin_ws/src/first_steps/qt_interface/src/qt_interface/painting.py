"""Draw the scene: in field units what scales with the field, in pixels waypoints and text."""

from __future__ import annotations

import math
from itertools import islice
from typing import Iterable

from PyQt5.QtCore import QLineF, QPointF, QRectF, Qt
from PyQt5.QtGui import QColor, QFont, QPainter, QPen, QPolygonF, QTransform

from qt_interface.scene import Point, Pose, Scene

GROUND = QColor("#e9edf1")
FLOOR = QColor("#fdfdfb")
GRID = QColor("#edf0f2")
AXIS = QColor("#dde3e8")
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
DOT_RADIUS = 4.0  # pixels, of a waypoint without one
LABEL_PIXELS = 24  # smallest distance of two numbered waypoints
GRID_PIXELS = 60  # largest distance of two grid lines
FADE_PIECES = 16  # the trail fades in so many steps


def draw(painter: QPainter, scene: Scene, view: QTransform, car: Pose | None) -> None:
    """Draw a frame.

    Args:
        painter: painter of the widget
        scene: the content
        view: transformation from field units to pixels
        car: where to draw the car
    """
    painter.setRenderHint(QPainter.Antialiasing)
    painter.setTransform(view)
    _draw_floor(painter, scene.walls, view)
    _draw_trail(painter, scene, car)
    if car is not None and scene.sizes.sensor_range:
        _draw_sensor(painter, scene, car)
    painter.resetTransform()
    _draw_waypoints(painter, scene, view)
    if car is not None:
        painter.setTransform(view)
        _draw_car(painter, car, max(scene.car_size, 8.0 / view.m11()))
        painter.resetTransform()
    if scene.is_paused:
        painter.setFont(_font(32))
        painter.setPen(FAINT_INK)
        painter.drawText(QRectF(0, 0, painter.window().width(), 80), Qt.AlignCenter, "paused")


def grid_step(scale: float) -> float:
    """Return the largest distance of 1, 2, 5, 10, 20, ... [u] that has at most 60 pixels."""
    length = GRID_PIXELS / scale
    power = 10.0 ** math.floor(math.log10(length))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length * (1.0 + 1e-9))


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


def _font(pixels: int) -> QFont:
    font = QFont("DejaVu Sans")
    font.setPixelSize(pixels)
    font.setBold(True)
    return font


def _pen(colour: QColor, pixels: float, style: Qt.PenStyle = Qt.SolidLine) -> QPen:
    """Return a pen whose width does not depend on the zoom."""
    pen = QPen(colour, pixels, style, Qt.FlatCap, Qt.MiterJoin)
    pen.setCosmetic(True)
    return pen


def _faint(colour: QColor, alpha: float) -> QColor:
    return QColor.fromRgbF(colour.redF(), colour.greenF(), colour.blueF(), alpha)


def _draw_floor(painter: QPainter, walls: QRectF | None, view: QTransform) -> None:
    """Draw the ground and the field with its grid and its walls."""
    visible = view.inverted()[0].mapRect(QRectF(painter.window()))
    inside = visible.intersected(walls or visible)
    painter.fillRect(visible, GROUND)
    painter.fillRect(inside, FLOOR)
    step = grid_step(view.m11())
    for line in range(math.ceil(inside.left() / step), math.floor(inside.right() / step) + 1):
        painter.setPen(_pen(GRID if line else AXIS, 1))
        painter.drawLine(QLineF(line * step, inside.top(), line * step, inside.bottom()))
    for line in range(math.ceil(inside.top() / step), math.floor(inside.bottom() / step) + 1):
        painter.setPen(_pen(GRID if line else AXIS, 1))
        painter.drawLine(QLineF(inside.left(), line * step, inside.right(), line * step))
    if walls:
        half = 3.0 / view.m11()
        painter.setBrush(Qt.NoBrush)
        painter.setPen(_pen(WALL, 6.0))
        painter.drawRect(walls.adjusted(-half, -half, half, half))


def _draw_trail(painter: QPainter, scene: Scene, car: Pose | None) -> None:
    """Draw the trail, older pieces fainter; its newest step ends where the car is drawn."""
    steps = list(scene.trail)
    if steps and car is not None and steps[-1].p2() == QPointF(*scene.car[:2]):
        steps[-1] = QLineF(steps[-1].p1(), QPointF(car.x, car.y))
    length = max(math.ceil(len(steps) / FADE_PIECES), 100)
    for age, end in enumerate(range(len(steps), 0, -length)):
        painter.setPen(_pen(_faint(CAR, 0.06 + 0.54 * (1.0 - age / FADE_PIECES) ** 2), 2.0))
        # Smooth edges take three times as long.
        painter.setRenderHint(QPainter.Antialiasing, age == 0)
        painter.drawLines(list(islice(steps, max(end - length, 0), end)))
    painter.setRenderHint(QPainter.Antialiasing)


def _draw_sensor(painter: QPainter, scene: Scene, car: Pose) -> None:
    """Draw the range of the sensor inside the walls: a disc, or its front half."""
    painter.save()
    if scene.walls:
        painter.setClipRect(scene.walls)
    painter.translate(car.x, car.y)
    painter.rotate(math.degrees(car.direction))
    painter.setBrush(_faint(SENSOR, 0.1))
    painter.setPen(_pen(SENSOR, 1.5, Qt.DashLine))
    radius = scene.sizes.sensor_range
    area = QRectF(-radius, -radius, 2 * radius, 2 * radius)
    if scene.sizes.sensor_front_only:
        painter.drawPie(area, -90 * 16, 180 * 16)
    else:
        painter.drawEllipse(area)
    painter.restore()


def _draw_waypoints(painter: QPainter, scene: Scene, view: QTransform) -> None:
    """Draw the waypoints, with numbers where these do not overlap, sensed ones, and the target."""
    labelled = labelled_points(scene.waypoints, view)

    def disc(point: Point, colour: QColor, pen: QPen, factor: float = 1.0, more: float = 0.0):
        radius = (DISC_RADIUS if point in labelled else DOT_RADIUS) * factor + more
        painter.setPen(pen)
        painter.setBrush(colour)
        painter.drawEllipse(QPointF(*view.map(point.x, point.y)), radius, radius)

    def numbered_disc(point: Point, colour: QColor, ink: QColor):
        disc(point, colour, _pen(Qt.white, 1.5))
        if point in labelled:
            x, y = view.map(point.x, point.y)
            number = str(point.idx)
            painter.setFont(_font(max(6, round(DISC_RADIUS * 1.05 * min(1.0, 2.3 / len(number))))))
            painter.setPen(ink)
            painter.drawText(QRectF(x - 22, y - 11, 44, 22), Qt.AlignCenter, number)

    for point in scene.waypoints:
        numbered_disc(point, WAYPOINT, Qt.white)
    for point in scene.sensed:
        disc(point, _faint(SENSED, 0.16), Qt.NoPen, 1.9)
        disc(point, _faint(SENSED, 0.31), Qt.NoPen, 1.45)
        numbered_disc(point, SENSED, INK)
    if scene.target is not None:
        disc(scene.target, Qt.transparent, _pen(TARGET, 3.0), more=5.0)


def _draw_car(painter: QPainter, car: Pose, size: float) -> None:
    """Draw the red square with a nose and a white arrow in its direction."""
    painter.translate(car.x, car.y)
    painter.rotate(math.degrees(car.direction))
    painter.scale(size, size)
    painter.setPen(_pen(CAR_EDGE, 1.5))
    painter.drawLine(QLineF(0.5, 0.0, 1.05, 0.0))
    painter.setBrush(CAR)
    painter.drawRoundedRect(QRectF(-0.5, -0.5, 1.0, 1.0), 0.12, 0.12)
    painter.setPen(Qt.NoPen)
    painter.setBrush(Qt.white)
    arrow = ((0.34, 0.0), (-0.2, 0.28), (-0.06, 0.0), (-0.2, -0.28))
    painter.drawPolygon(QPolygonF([QPointF(x, y) for x, y in arrow]))
