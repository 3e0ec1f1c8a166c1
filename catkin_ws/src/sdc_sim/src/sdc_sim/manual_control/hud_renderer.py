"""Draw the head-up display on a pygame surface."""

from __future__ import annotations

from typing import Sequence, Tuple

from sdc_common.window import pygame
from sdc_sim.manual_control import hud
from sdc_sim.manual_control.keyboard import HELP

_Colour = Tuple[int, int, int]
_PANEL = (0, 0, 0, 140)
_TEXT = (255, 255, 255)
_LABEL = (185, 195, 205)
_BAR = (235, 235, 235)
_TROUGH = (95, 100, 105, 210)
_ON = (255, 190, 60)
_MANUAL, _AUTOPILOT = (255, 190, 60), (110, 220, 130)

_WIDTH, _MARGIN, _ROW, _BAR_HEIGHT = 196, 12, 20, 8


class HudRenderer:
    """Draws the panel of readings, the help next to it, and the notices at the bottom."""

    def __init__(self):
        pygame.font.init()
        self._font = pygame.font.Font(None, 20)
        self._large = pygame.font.Font(None, 26)

    def draw(
        self,
        screen: pygame.Surface,
        readings: hud.Readings,
        notices: Sequence[tuple[str, float]],
        show_panel: bool,
        show_help: bool,
    ) -> None:
        """Draw on the screen; notices are rows of (text, opacity in 0..1)."""
        if show_panel:
            self._draw_panel(screen, readings)
        if show_help:
            self._draw_help(screen)
        self._draw_notices(screen, notices)

    def draw_centred(self, screen: pygame.Surface, text: str) -> None:
        """Draw one line of text in the middle of the screen."""
        line = self._font.render(text, True, _TEXT)
        screen.blit(line, line.get_rect(center=screen.get_rect().center))

    def _draw_panel(self, screen: pygame.Surface, readings: hud.Readings) -> None:
        panel = pygame.Surface((_WIDTH, screen.get_height()), pygame.SRCALPHA)
        panel.fill(_PANEL)
        y = _MARGIN
        for label, value in hud.lines(readings):
            colour = _TEXT
            if label == "Driver":
                y += 6
                colour = _MANUAL if readings.manual else _AUTOPILOT
            self._row(panel, y, label, value, colour)
            y += 26 if label in ("Client", "Time", "Location") else _ROW
        y += 8
        for name, level, minimum in hud.bars(readings.command):
            self._bar(panel, y, name, level, minimum)
            y += _ROW
        y += 6
        for label, is_on in hud.flags(readings.command):
            self._row(panel, y, label, "ON" if is_on else "off", _ON if is_on else _LABEL)
            y += _ROW
        hint = self._font.render("H help", True, _LABEL)
        panel.blit(hint, (_MARGIN, screen.get_height() - _MARGIN - hint.get_height()))
        screen.blit(panel, (0, 0))

    def _row(self, panel: pygame.Surface, y: int, label: str, value: str, colour: _Colour) -> None:
        panel.blit(self._font.render(label, True, _LABEL), (_MARGIN, y))
        text = self._font.render(value, True, colour)
        panel.blit(text, (_WIDTH - _MARGIN - text.get_width(), y))

    def _bar(self, panel: pygame.Surface, y: int, label: str, value: float, minimum: float) -> None:
        panel.blit(self._font.render(label, True, _LABEL), (_MARGIN, y))
        left = 84
        trough = pygame.Rect(left, y + 3, _WIDTH - _MARGIN - left, _BAR_HEIGHT)
        pygame.draw.rect(panel, _TROUGH, trough)
        span = trough.width / (1.0 - minimum)
        zero = trough.left - minimum * span
        tip = zero + min(max(value, minimum), 1.0) * span
        if minimum < 0.0:  # a line at zero and a knob: both are visible at any value
            pygame.draw.line(panel, _LABEL, (zero, trough.top - 2), (zero, trough.bottom + 1))
            pygame.draw.rect(
                panel,
                _BAR,
                pygame.Rect(min(zero, tip) - 2, trough.top, abs(tip - zero) + 4, _BAR_HEIGHT),
            )
        else:
            pygame.draw.rect(
                panel, _BAR, pygame.Rect(trough.left, trough.top, tip - trough.left, _BAR_HEIGHT)
            )

    def _draw_help(self, screen: pygame.Surface) -> None:
        panel = pygame.Surface((390, 2 * _MARGIN + _ROW * len(HELP)), pygame.SRCALPHA)
        panel.fill((0, 0, 0, 180))
        for row, (keys, action) in enumerate(HELP):
            panel.blit(self._font.render(keys, True, _ON), (_MARGIN, _MARGIN + _ROW * row))
            panel.blit(self._font.render(action, True, _TEXT), (_MARGIN + 90, _MARGIN + _ROW * row))
        screen.blit(panel, panel.get_rect(centerx=(screen.get_width() + _WIDTH) // 2, top=60))

    def _draw_notices(self, screen: pygame.Surface, notices: Sequence[tuple[str, float]]) -> None:
        y = screen.get_height() - _MARGIN
        for text, opacity in reversed(notices):
            line = self._large.render(text, True, _TEXT)
            plate = pygame.Surface((line.get_width() + 24, line.get_height() + 12), pygame.SRCALPHA)
            plate.fill((0, 0, 0, 170))
            plate.blit(line, (12, 6))
            plate.set_alpha(round(255 * opacity))
            y -= plate.get_height() + 4
            screen.blit(plate, plate.get_rect(centerx=(screen.get_width() + _WIDTH) // 2, top=y))
