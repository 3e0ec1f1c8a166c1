"""The head-up display of the manual control: its texts, and how they are drawn with pygame."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from datetime import timedelta
from typing import Any

from sdc_common.driving import Command
from sdc_common.window import pygame
from sdc_sim.manual_control.keyboard import HELP
from sdc_sim.yaml_document import packaged_config

_COMPASS_POINTS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
# Values of crossed_lane_markings in carla_msgs/CarlaLaneInvasionEvent.
_MARKINGS = {0: "other", 1: "broken", 2: "solid"}
# Labels of the panel, and their texts with the names of the readings.
_LINES: dict[str, str] = packaged_config("hud")
_LAST_OF_GROUP = ("Client", "Time", "Location", "Driver", "Brake")

_TEXT, _LABEL, _BAR, _TROUGH = (255, 255, 255), (185, 195, 205), (235, 235, 235), (95, 100, 105)
_ON, _AUTOPILOT, _PLATE = (255, 190, 60), (110, 220, 130), (0, 0, 0, 150)
_WIDTH, _MARGIN, _ROW, _GAP, _BAR_LEFT, _BAR_HEIGHT = 196, 12, 20, 6, 84, 8


def compass(yaw_rad: float) -> str:
    """Return a heading from north and the nearest compass point, such as "90° E"."""
    degrees = (90.0 - math.degrees(yaw_rad)) % 360.0
    point = _COMPASS_POINTS[int((degrees + 22.5) // 45.0) % 8]
    return f"{round(degrees) % 360}\N{DEGREE SIGN} {point}"


def clock(time_s: float) -> str:
    """Return a time [s] as hours, minutes and seconds: 0:00:00.0."""
    tenths = int(time_s * 10.0 + 1e-6)
    return f"{timedelta(seconds=tenths // 10)}.{tenths % 10}"


def lines(readings: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return readings, by the names in _LINES, as rows of (label, text); "-" if one is missing."""
    rows = []
    for label, text in _LINES.items():
        try:
            rows.append((label, text.format_map(readings)))
        except KeyError:
            rows.append((label, "-"))
    return rows


def crossed_line_text(markings: Collection[int]) -> str:
    """Return the notice for the values of crossed_lane_markings."""
    names = sorted({_MARKINGS.get(marking, "other") for marking in markings})
    return f"Crossed line: {' and '.join(names)}" if names else "Crossed line"


class Hud:
    """Draws the panel of readings, the help next to it, and the notices at the bottom."""

    def __init__(self):
        pygame.font.init()
        self._font = pygame.font.Font(None, 20)
        self._large = pygame.font.Font(None, 26)

    def draw_centred(self, screen: pygame.Surface, text: str) -> None:
        """Draw one line of text in the middle of the screen."""
        line = self._font.render(text, True, _TEXT)
        screen.blit(line, line.get_rect(center=screen.get_rect().center))

    def draw_panel(
        self, screen: pygame.Surface, readings: Mapping[str, Any], command: Command
    ) -> None:
        """Draw the readings and the command at the left of the screen."""
        panel = _plate(_WIDTH, screen.get_height())
        is_manual = readings["driver"] == "manual"
        colours = {"Driver": _ON if is_manual else _AUTOPILOT}
        rows: list[tuple[str, Any]] = lines(readings)
        rows += [("Throttle", (command.throttle, 0.0)), ("Steer", (command.steer, -1.0))]
        rows.append(("Brake", (command.brake, 0.0)))
        for label, is_on in (("Reverse", command.reverse), ("Hand brake", command.hand_brake)):
            rows.append((label, "ON" if is_on else "off"))
            colours[label] = _ON if is_on else _LABEL
        y = _MARGIN
        for label, value in rows:
            panel.blit(self._font.render(label, True, _LABEL), (_MARGIN, y))
            if isinstance(value, str):
                text = self._font.render(value, True, colours.get(label, _TEXT))
                panel.blit(text, (_WIDTH - _MARGIN - text.get_width(), y))
            else:
                _draw_bar(panel, y, *value)
            y += _ROW + (_GAP if label in _LAST_OF_GROUP else 0)
        hint = self._font.render("H help", True, _LABEL)
        panel.blit(hint, (_MARGIN, screen.get_height() - _MARGIN - hint.get_height()))
        screen.blit(panel, (0, 0))

    def draw_help(self, screen: pygame.Surface) -> None:
        """Draw what the keys do."""
        panel = _plate(390, 2 * _MARGIN + _ROW * len(HELP))
        for row, (keys, action) in enumerate(HELP):
            panel.blit(self._font.render(keys, True, _ON), (_MARGIN, _MARGIN + _ROW * row))
            panel.blit(self._font.render(action, True, _TEXT), (_MARGIN + 90, _MARGIN + _ROW * row))
        screen.blit(panel, panel.get_rect(centerx=(screen.get_width() + _WIDTH) // 2, top=60))

    def draw_notices(self, screen: pygame.Surface, notices: Sequence[tuple[str, float]]) -> None:
        """Draw rows of (text, opacity in 0..1), the last one at the bottom."""
        y = screen.get_height() - _MARGIN
        for text, opacity in reversed(notices):
            line = self._large.render(text, True, _TEXT)
            plate = _plate(line.get_width() + 24, line.get_height() + 12)
            plate.blit(line, (12, 6))
            plate.set_alpha(round(255 * opacity))
            y -= plate.get_height() + 4
            screen.blit(plate, plate.get_rect(centerx=(screen.get_width() + _WIDTH) // 2, top=y))


def _plate(width_px: int, height_px: int) -> pygame.Surface:
    plate = pygame.Surface((width_px, height_px), pygame.SRCALPHA)
    plate.fill(_PLATE)
    return plate


def _draw_bar(panel: pygame.Surface, y: int, value: float, minimum: float) -> None:
    """Draw a bar from zero to a value, with a knob where the value can have either sign."""
    left, width, top = _BAR_LEFT, _WIDTH - _MARGIN - _BAR_LEFT, y + 3
    zero, tip = (
        left + width * (end_value - minimum) / (1.0 - minimum)
        for end_value in (0.0, min(max(value, minimum), 1.0))
    )
    knob = 2 if minimum < 0.0 else 0
    pygame.draw.rect(panel, _TROUGH, (left, top, width, _BAR_HEIGHT))
    pygame.draw.line(panel, _LABEL, (zero, top - knob), (zero, top + _BAR_HEIGHT - 1 + knob))
    bar = pygame.Rect(min(zero, tip) - knob, top, abs(tip - zero) + 2 * knob, _BAR_HEIGHT)
    pygame.draw.rect(panel, _BAR, bar)
