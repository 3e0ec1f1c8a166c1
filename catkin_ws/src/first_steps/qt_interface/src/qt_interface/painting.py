"""Drawing functions for every item on the field.

Positions and sizes are in pixels of the widget.
"""

from __future__ import annotations

import math

from PyQt5.QtCore import QLineF, QPointF, QRectF, Qt
from PyQt5.QtGui import QColor, QFont, QPainter, QPen, QPolygonF, QTransform

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

DISC_RADIUS = 11.0  # of a waypoint with a number
DOT_RADIUS = 4.0  # of a waypoint without one
GRID_PIXELS = 60  # largest distance of two grid lines


def start(painter: QPainter) -> None:
    """Enable smooth edges."""
    painter.setRenderHint(QPainter.Antialiasing)
    painter.setRenderHint(QPainter.TextAntialiasing)


def font(pixels: int, is_bold: bool = False) -> QFont:
    """Return the font of the window in this size."""
    result = QFont("DejaVu Sans")
    result.setPixelSize(pixels)
    result.setBold(is_bold)
    return result


def disc(
    painter: QPainter, x: float, y: float, radius: float, colour: QColor, number: str = ""
) -> None:
    """Draw a waypoint: a disc with its number."""
    painter.setPen(QPen(Qt.white, 1.5))
    painter.setBrush(colour)
    painter.drawEllipse(QPointF(x, y), radius, radius)
    if number:
        pixels = radius * 1.05 * min(1.0, 2.3 / len(number))
        painter.setFont(font(max(6, round(pixels)), is_bold=True))
        painter.setPen(INK if colour == SENSED else Qt.white)
        painter.drawText(
            QRectF(x - 2 * radius, y - radius, 4 * radius, 2 * radius), Qt.AlignCenter, number
        )


def glow(painter: QPainter, x: float, y: float, radius: float) -> None:
    """Draw the halo of a waypoint that the sensor detects."""
    painter.setPen(Qt.NoPen)
    for factor, alpha in ((1.9, 40), (1.45, 80)):
        colour = QColor(SENSED)
        colour.setAlpha(alpha)
        painter.setBrush(colour)
        painter.drawEllipse(QPointF(x, y), radius * factor, radius * factor)


def ring(painter: QPainter, x: float, y: float, radius: float) -> None:
    """Draw the ring around the target."""
    painter.setBrush(Qt.NoBrush)
    painter.setPen(QPen(TARGET, 3.0))
    painter.drawEllipse(QPointF(x, y), radius + 5.0, radius + 5.0)


def sensor(
    painter: QPainter, x: float, y: float, radius: float, direction: float, front_only: bool
) -> None:
    """Draw the sensor's range: a disc, or its front half for a sensor with `front_only`.

    Args:
        painter: painter of the widget
        x: position of the car
        y: position of the car
        radius: range of the sensor
        direction: direction of the car [rad]
        front_only: True if the sensor detects no points behind the car
    """
    fill = QColor(SENSOR)
    fill.setAlpha(26)
    painter.setBrush(fill)
    painter.setPen(QPen(SENSOR, 1.5, Qt.DashLine))
    if front_only:
        area = QRectF(x - radius, y - radius, 2 * radius, 2 * radius)
        painter.drawPie(area, round((math.degrees(direction) - 90.0) * 16), 180 * 16)
    else:
        painter.drawEllipse(QPointF(x, y), radius, radius)


def car(painter: QPainter, x: float, y: float, size: float, direction: float) -> None:
    """Draw the red square with a white arrow in its direction.

    Args:
        painter: painter of the widget
        x: position of the centre
        y: position of the centre
        size: side of the square
        direction: direction of the car [rad]
    """
    painter.save()
    painter.translate(x, y)
    painter.rotate(-math.degrees(direction))
    half = size / 2.0
    painter.setPen(QPen(CAR_EDGE, 1.5))
    painter.drawLine(QPointF(half, 0.0), QPointF(half + 0.55 * size, 0.0))
    painter.setBrush(CAR)
    painter.drawRoundedRect(QRectF(-half, -half, size, size), size * 0.12, size * 0.12)
    painter.setPen(Qt.NoPen)
    painter.setBrush(Qt.white)
    painter.drawPolygon(
        QPolygonF(
            [
                QPointF(0.34 * size, 0.0),
                QPointF(-0.2 * size, 0.28 * size),
                QPointF(-0.06 * size, 0.0),
                QPointF(-0.2 * size, -0.28 * size),
            ]
        )
    )
    painter.restore()


def trail(
    painter: QPainter, points: list[tuple[float, float]], jump: float, freshness: float
) -> None:
    """Draw a piece of trail in pixels.

    Args:
        painter: painter of the widget
        points: positions of the car
        jump: a longer step is not drawn: the car was moved by hand
        freshness: 1 for the newest piece and 0 for the oldest
    """
    steps = zip(points, points[1:])
    lines = [QLineF(*begin, *end) for begin, end in steps if math.dist(begin, end) <= jump]
    colour = QColor(CAR)
    colour.setAlphaF(0.06 + 0.54 * min(max(freshness, 0.0), 1.0) ** 2)
    painter.setPen(QPen(colour, 2.0, Qt.SolidLine, Qt.FlatCap))
    painter.drawLines(lines)


def floor(painter: QPainter, view: QTransform, whole: QRectF, walls: QRectF | None) -> None:
    """Draw the ground and the field with its grid and its walls.

    Args:
        painter: painter of the widget
        view: transformation from field units to pixels
        whole: the widget
        walls: the field, or None for a floor without walls
    """
    inside = walls or whole
    painter.fillRect(whole, GROUND)
    painter.fillRect(inside, FLOOR)
    painter.save()
    painter.setClipRect(inside)
    painter.setRenderHint(QPainter.Antialiasing, False)
    visible = view.inverted()[0].mapRect(whole)
    step = grid_step(view.m11())
    for line in range(math.ceil(visible.left() / step), math.floor(visible.right() / step) + 1):
        x = view.map(line * step, 0.0)[0]
        painter.setPen(QPen(AXIS if line == 0 else GRID, 1))
        painter.drawLine(QPointF(x, whole.top()), QPointF(x, whole.bottom()))
    for line in range(math.ceil(visible.top() / step), math.floor(visible.bottom() / step) + 1):
        y = view.map(0.0, line * step)[1]
        painter.setPen(QPen(AXIS if line == 0 else GRID, 1))
        painter.drawLine(QPointF(whole.left(), y), QPointF(whole.right(), y))
    painter.restore()
    if walls:
        painter.setBrush(Qt.NoBrush)
        painter.setPen(QPen(WALL, 6.0, Qt.SolidLine, Qt.SquareCap, Qt.MiterJoin))
        painter.drawRect(walls.adjusted(-3.0, -3.0, 3.0, 3.0))


def grid_step(scale: float) -> float:
    """Return the largest distance of 1, 2, 5, 10, 20, ... [u] that has at most 60 pixels."""
    length = GRID_PIXELS / scale
    power = 10.0 ** math.floor(math.log10(length))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length * (1.0 + 1e-9))
