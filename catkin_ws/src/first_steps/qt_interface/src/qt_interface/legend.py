"""The column next to the field: lap count, explanation of the symbols, mouse and keys."""

from __future__ import annotations

from PyQt5.QtCore import QPointF, QRectF, Qt
from PyQt5.QtGui import QColor, QPainter, QPaintEvent, QPen
from PyQt5.QtWidgets import QWidget

from qt_interface import painting
from qt_interface.scene import Scene

WIDTH = 240
FIRST_ROW, ROW = 152, 34  # y of the first symbol, and the distance to the next
SYMBOL_X = 34
RADIUS = 0.8 * painting.DISC_RADIUS
KEYS = (
    ("drag the square", "carry the car"),
    ("click", "add a waypoint"),
    ("wheel", "zoom"),
    ("drag the floor", "pan"),
    ("space", "pause"),
    ("R", "reset"),
    ("F", "show all"),
    ("Q", "quit"),
)


def _trail(painter: QPainter, x: float, y: float) -> None:
    for part in range(8):
        painter.setPen(painting.trail_pen((part + 1) / 8.0))
        painter.drawLine(QPointF(x - 18 + 4.5 * part, y), QPointF(x - 13.5 + 4.5 * part, y))


def _sensed(painter: QPainter, x: float, y: float) -> None:
    painting.glow(painter, x, y, RADIUS)
    painting.disc(painter, x, y, RADIUS, painting.SENSED, "8")


def _target(painter: QPainter, x: float, y: float) -> None:
    painting.disc(painter, x, y, RADIUS, painting.WAYPOINT, "9")
    painting.ring(painter, x, y, RADIUS)


SYMBOLS = {
    "the car": lambda painter, x, y: painting.car(painter, x - 4, y, 18.0, 0.0),
    "its trail": _trail,
    "sensor range": lambda painter, x, y: painting.sensor(painter, x, y, 13.0, 0.0, False),
    "waypoint": lambda painter, x, y: painting.disc(
        painter, x, y, painting.DISC_RADIUS, painting.WAYPOINT, "7"
    ),
    "sensed now": _sensed,
    "target": _target,
}


class Legend(QWidget):
    """A widget that shows the lap count and explains the window."""

    def __init__(self, scene: Scene, parent: QWidget | None = None):
        super().__init__(parent)
        self.scene = scene
        self.setFixedWidth(WIDTH)
        self.setMinimumHeight(600)

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Draw the column."""
        painter = QPainter(self)
        painting.start(painter)
        painter.fillRect(self.rect(), painting.GROUND)
        laps = self.scene.laps
        number = "\N{EN DASH}" if laps is None else str(laps)
        _text(painter, 0, 55, number, 58, painting.INK, is_bold=True, align=Qt.AlignCenter)
        unit = "lap" if laps == 1 else "laps"
        _text(painter, 0, 99, unit, 14, painting.FAINT_INK, align=Qt.AlignCenter)
        painter.setPen(QPen(painting.AXIS, 1))
        painter.drawLine(QPointF(16, 124), QPointF(WIDTH - 16, 124))
        y = FIRST_ROW
        for text, paint_symbol in SYMBOLS.items():
            paint_symbol(painter, SYMBOL_X, y)
            _text(painter, 66, y, text, 14, painting.INK)
            y += ROW
        y += 14
        for key, meaning in KEYS:
            _text(painter, 16, y, key, 12, painting.INK, is_bold=True)
            _text(painter, 134, y, meaning, 12, painting.FAINT_INK)
            y += 22
        painter.end()


def _text(
    painter: QPainter,
    x: int,
    y: int,
    text: str,
    pixels: int,
    colour: QColor,
    is_bold: bool = False,
    align: Qt.AlignmentFlag = Qt.AlignLeft,
) -> None:
    painter.setFont(painting.font(pixels, is_bold))
    painter.setPen(colour)
    area = QRectF(x, y - pixels, WIDTH - x, 2 * pixels)
    painter.drawText(area, Qt.AlignVCenter | align, text)
