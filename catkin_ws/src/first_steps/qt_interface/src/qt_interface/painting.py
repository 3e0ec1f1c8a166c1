"""Drawing functions for every item on the field, shared by the field and the legend.

Positions and sizes are in pixels of the widget.
"""

from __future__ import annotations

import math

from PyQt5.QtCore import QPointF, QRectF, Qt
from PyQt5.QtGui import QColor, QFont, QPainter, QPen, QPolygonF

from qt_interface.view import View, nice_step

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


def trail_pen(freshness: float) -> QPen:
    """Return the pen for a piece of trail; `freshness` is 1 for the newest and 0 for the oldest."""
    colour = QColor(CAR)
    colour.setAlphaF(0.06 + 0.54 * min(max(freshness, 0.0), 1.0) ** 2)
    return QPen(colour, 2.0, Qt.SolidLine, Qt.FlatCap)


def area(view: View, walls: tuple[float, float] | None) -> QRectF:
    """Return the part of the widget inside the walls, or all of it without walls.

    Args:
        view: visible part of the field
        walls: largest |x| and |y| of the field [u], or None
    """
    if walls is None:
        return QRectF(0, 0, view.width, view.height)
    left, bottom = view.to_pixel(-walls[0], -walls[1])
    right, top = view.to_pixel(*walls)
    return QRectF(left, top, right - left, bottom - top)


def floor(painter: QPainter, view: View, walls: tuple[float, float] | None) -> None:
    """Draw the ground and the field with its grid and its walls, if it has walls."""
    painter.fillRect(QRectF(0, 0, view.width, view.height), GROUND)
    inside = area(view, walls)
    painter.fillRect(inside, FLOOR)
    step = nice_step(GRID_PIXELS / view.scale)
    (low_x, high_y), (high_x, low_y) = view.to_field(0, 0), view.to_field(view.width, view.height)
    painter.save()
    painter.setClipRect(inside)
    painter.setRenderHint(QPainter.Antialiasing, False)
    for line in range(math.ceil(low_x / step), math.floor(high_x / step) + 1):
        x = view.to_pixel(line * step, 0.0)[0]
        painter.setPen(QPen(AXIS if line == 0 else GRID, 1))
        painter.drawLine(QPointF(x, 0), QPointF(x, view.height))
    for line in range(math.ceil(low_y / step), math.floor(high_y / step) + 1):
        y = view.to_pixel(0.0, line * step)[1]
        painter.setPen(QPen(AXIS if line == 0 else GRID, 1))
        painter.drawLine(QPointF(0, y), QPointF(view.width, y))
    painter.restore()
    if walls:
        painter.setBrush(Qt.NoBrush)
        painter.setPen(QPen(WALL, 6.0, Qt.SolidLine, Qt.SquareCap, Qt.MiterJoin))
        painter.drawRect(inside.adjusted(-3.0, -3.0, 3.0, 3.0))
