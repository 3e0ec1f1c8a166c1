"""Drawing functions for every item on the field, shared by the field and the legend.

Positions and sizes are in pixels of the widget.
"""

from __future__ import annotations

import math

from PyQt5.QtCore import QPointF, QRectF, Qt
from PyQt5.QtGui import QBrush, QColor, QFont, QPainter, QPen, QPolygonF

from qt_interface.view import View

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


def start(painter: QPainter) -> None:
    """Enable smooth edges."""
    painter.setRenderHint(QPainter.Antialiasing)
    painter.setRenderHint(QPainter.TextAntialiasing)


def number_font(radius: float) -> QFont:
    """Return the font of the numbers in discs of this radius."""
    font = QFont("DejaVu Sans")
    font.setPixelSize(max(6, round(radius * 1.05)))
    font.setBold(True)
    return font


def disc(
    painter: QPainter, x: float, y: float, radius: float, colour: QColor, number: str = ""
) -> None:
    """Draw a waypoint: a disc with its number."""
    painter.setPen(QPen(Qt.white, 1.5))
    painter.setBrush(colour)
    painter.drawEllipse(QPointF(x, y), radius, radius)
    if number:
        font = number_font(radius)
        if len(number) > 2:
            font.setPixelSize(max(6, round(font.pixelSize() * 2.3 / len(number))))
        painter.setFont(font)
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
    pen = QPen(colour, 2.0, Qt.SolidLine, Qt.FlatCap)
    pen.setCosmetic(True)
    return pen


def floor(
    painter: QPainter, view: View, walls: tuple[float, float] | None, grid_step: float
) -> None:
    """Draw the ground and the field with its grid and its walls.

    Args:
        painter: painter of the widget
        view: visible part of the field
        walls: width and height of the field [u], or None for a floor without walls
        grid_step: distance of the grid lines [u]
    """
    painter.fillRect(QRectF(0, 0, view.width, view.height), QBrush(GROUND if walls else FLOOR))
    if walls:
        left, top = view.to_pixel(-walls[0] / 2.0, walls[1] / 2.0)
        right, bottom = view.to_pixel(walls[0] / 2.0, -walls[1] / 2.0)
    else:
        left, top, right, bottom = 0.0, 0.0, float(view.width), float(view.height)
    area = QRectF(left, top, right - left, bottom - top)
    painter.fillRect(area, FLOOR)
    low_x, low_y = view.to_field(max(left, 0.0), min(bottom, view.height))
    high_x, high_y = view.to_field(min(right, view.width), max(top, 0.0))
    painter.save()
    painter.setClipRect(area)
    painter.setRenderHint(QPainter.Antialiasing, False)
    for line in range(math.ceil(low_x / grid_step), math.floor(high_x / grid_step) + 1):
        x = view.to_pixel(line * grid_step, 0.0)[0]
        painter.setPen(QPen(AXIS if line == 0 else GRID, 1))
        painter.drawLine(QPointF(x, area.top()), QPointF(x, area.bottom()))
    for line in range(math.ceil(low_y / grid_step), math.floor(high_y / grid_step) + 1):
        y = view.to_pixel(0.0, line * grid_step)[1]
        painter.setPen(QPen(AXIS if line == 0 else GRID, 1))
        painter.drawLine(QPointF(area.left(), y), QPointF(area.right(), y))
    painter.restore()
    if walls:
        painter.setBrush(Qt.NoBrush)
        painter.setPen(QPen(WALL, 6.0, Qt.SolidLine, Qt.SquareCap, Qt.MiterJoin))
        painter.drawRect(area.adjusted(-3.0, -3.0, 3.0, 3.0))
