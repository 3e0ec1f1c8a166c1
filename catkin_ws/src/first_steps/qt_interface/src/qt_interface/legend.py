"""The column next to the field: lap count, explanation of the symbols, mouse and keys."""

from __future__ import annotations

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QLabel

from qt_interface import field

SYMBOLS = (
    ("\N{BLACK SQUARE}", field.CAR, "the car"),
    ("\N{BOX DRAWINGS HEAVY HORIZONTAL}", field.CAR.lighter(150), "its trail"),
    ("\N{DOTTED CIRCLE}", field.SENSOR, "sensor range"),
    ("\N{BLACK CIRCLE}", field.WAYPOINT, "waypoint"),
    ("\N{BLACK CIRCLE}", field.SENSED, "sensed now"),
    ("\N{WHITE CIRCLE}", field.TARGET, "target"),
)
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


class Legend(QLabel):
    """A label that shows the lap count and explains the window."""

    def __init__(self):
        super().__init__()
        self.setFixedWidth(240)
        self.setAlignment(Qt.AlignTop)
        self.setMargin(12)
        self.setStyleSheet(
            f"background: {field.GROUND.name()}; color: {field.INK.name()};"
            "font-family: 'DejaVu Sans'; font-size: 12px"
        )
        self.set_laps(None)

    def set_laps(self, laps: int | None) -> None:
        """Show the number of completed laps; None if it is not known."""
        number = "\N{EN DASH}" if laps is None else laps
        symbols = "".join(
            f"<tr><td style='font-size: 24px; color: {colour.name()}'>{symbol}</td>"
            f"<td style='font-size: 14px; padding: 8px'>{text}</td></tr>"
            for symbol, colour, text in SYMBOLS
        )
        keys = "".join(
            f"<tr><td><b>{key}</b></td><td style='padding-left: 8px'>{meaning}</td></tr>"
            for key, meaning in KEYS
        )
        self.setText(
            f"<p align='center'><b style='font-size: 58px'>{number}</b><br>"
            f"{'lap' if laps == 1 else 'laps'}</p><hr>"
            f"<table>{symbols}</table><br><table cellspacing='3'>{keys}</table>"
        )
