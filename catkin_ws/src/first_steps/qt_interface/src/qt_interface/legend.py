"""The column next to the field: lap count, explanation of the symbols, mouse and keys."""

from __future__ import annotations

from PyQt5.QtCore import QPointF, QRectF, Qt
from PyQt5.QtGui import QColor, QFont, QPainter, QPaintEvent, QPen, QPolygonF
from PyQt5.QtWidgets import QWidget

from qt_interface import painting
from qt_interface.scene import Scene

WIDTH = 240
ROW = 34
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
        self._paint_laps(painter)
        y = 152.0
        for paint_symbol, text in (
            (self._car, "the car"),
            (self._trail, "its trail"),
            (self._sensor, "sensor range"),
            (self._waypoint, "waypoint"),
            (self._sensed, "sensed now"),
            (self._target, "target"),
        ):
            paint_symbol(painter, 34.0, y)
            _text(painter, 66.0, y, text, 14, painting.INK)
            y += ROW
        y += 14.0
        for key, meaning in KEYS:
            _text(painter, 16.0, y, key, 12, painting.INK, is_bold=True)
            _text(painter, 134.0, y, meaning, 12, painting.FAINT_INK)
            y += 22.0
        painter.end()

    def _paint_laps(self, painter: QPainter) -> None:
        painter.setPen(painting.INK)
        font = QFont("DejaVu Sans")
        font.setPixelSize(58)
        font.setBold(True)
        painter.setFont(font)
        painter.drawText(
            QRectF(0, 22, WIDTH, 66),
            Qt.AlignCenter,
            "\N{EN DASH}" if self.scene.laps is None else str(self.scene.laps),
        )
        font.setPixelSize(14)
        font.setBold(False)
        painter.setFont(font)
        painter.setPen(painting.FAINT_INK)
        painter.drawText(
            QRectF(0, 88, WIDTH, 22), Qt.AlignCenter, "lap" if self.scene.laps == 1 else "laps"
        )
        painter.setPen(QPen(painting.AXIS, 1))
        painter.drawLine(QPointF(16, 124), QPointF(WIDTH - 16, 124))

    @staticmethod
    def _car(painter: QPainter, x: float, y: float) -> None:
        painting.car(painter, x - 4, y, 18.0, 0.0)

    @staticmethod
    def _trail(painter: QPainter, x: float, y: float) -> None:
        for part in range(8):
            painter.setPen(painting.trail_pen((part + 1) / 8.0))
            painter.drawPolyline(
                QPolygonF([QPointF(x - 18 + 4.5 * part, y), QPointF(x - 13.5 + 4.5 * part, y)])
            )

    @staticmethod
    def _sensor(painter: QPainter, x: float, y: float) -> None:
        painting.sensor(painter, x, y, 13.0, 0.0, False)

    @staticmethod
    def _waypoint(painter: QPainter, x: float, y: float) -> None:
        painting.disc(painter, x, y, painting.DISC_RADIUS, painting.WAYPOINT, "7")

    @staticmethod
    def _sensed(painter: QPainter, x: float, y: float) -> None:
        painting.glow(painter, x, y, painting.DISC_RADIUS * 0.8)
        painting.disc(painter, x, y, painting.DISC_RADIUS * 0.8, painting.SENSED, "8")

    @staticmethod
    def _target(painter: QPainter, x: float, y: float) -> None:
        painting.disc(painter, x, y, painting.DISC_RADIUS * 0.8, painting.WAYPOINT, "9")
        painting.ring(painter, x, y, painting.DISC_RADIUS * 0.8)


def _text(
    painter: QPainter,
    x: float,
    y: float,
    text: str,
    pixels: int,
    colour: QColor,
    is_bold: bool = False,
) -> None:
    font = QFont("DejaVu Sans")
    font.setPixelSize(pixels)
    font.setBold(is_bold)
    painter.setFont(font)
    painter.setPen(colour)
    painter.drawText(QRectF(x, y - 14, WIDTH - x, 28), Qt.AlignVCenter | Qt.AlignLeft, text)
