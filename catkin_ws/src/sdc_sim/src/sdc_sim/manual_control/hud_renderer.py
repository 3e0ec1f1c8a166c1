"""Draws the head-up display on a pygame surface."""

from __future__ import annotations

import os

from sdc_sim.manual_control import hud
from sdc_sim.manual_control.keyboard import HELP

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
import pygame  # noqa: E402  the line above must stand before it

_PANEL = (0, 0, 0, 140)
_TEXT = (255, 255, 255)
_LABEL = (185, 195, 205)
_BAR = (235, 235, 235)
_TROUGH = (95, 100, 105, 210)
_LIT = (255, 190, 60)
_MANUAL, _AUTOPILOT = (255, 190, 60), (110, 220, 130)

_WIDTH, _MARGIN, _ROW, _BAR_HEIGHT = 196, 12, 20, 8


class HudRenderer:
    """The panel of figures, the help and the notices. The help stands beside the panel, notices at the bottom."""

    def __init__(self):
        pygame.font.init()
        self._font = pygame.font.Font(None, 20)
        self._large = pygame.font.Font(None, 26)

    def draw(self, screen, readings, notices, show_figures: bool, show_help: bool) -> None:
        """Draw on `screen`; readings: hud.Readings, notices: rows of (text, strength)."""
        if show_figures:
            self._draw_panel(screen, readings)
        if show_help:
            self._draw_help(screen)
        self._draw_notices(screen, notices)

    def draw_centred(self, screen, text: str) -> None:
        """One line in the middle of the screen."""
        line = self._font.render(text, True, _TEXT)
        screen.blit(line, line.get_rect(center=screen.get_rect().center))

    def _draw_panel(self, screen, readings):
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
        for label, value, lowest in hud.bars(readings.command):
            self._bar(panel, y, label, value, lowest)
            y += _ROW
        y += 6
        for label, lit in hud.flags(readings.command):
            self._row(panel, y, label, "ON" if lit else "off", _LIT if lit else _LABEL)
            y += _ROW
        hint = self._font.render("H help", True, _LABEL)
        panel.blit(hint, (_MARGIN, screen.get_height() - _MARGIN - hint.get_height()))
        screen.blit(panel, (0, 0))

    def _row(self, panel, y, label, value, colour):
        panel.blit(self._font.render(label, True, _LABEL), (_MARGIN, y))
        text = self._font.render(value, True, colour)
        panel.blit(text, (_WIDTH - _MARGIN - text.get_width(), y))

    def _bar(self, panel, y, label, value, lowest):
        panel.blit(self._font.render(label, True, _LABEL), (_MARGIN, y))
        left = 84
        trough = pygame.Rect(left, y + 3, _WIDTH - _MARGIN - left, _BAR_HEIGHT)
        pygame.draw.rect(panel, _TROUGH, trough)
        span = trough.width / (1.0 - lowest)
        zero = trough.left - lowest * span
        tip = zero + min(max(value, lowest), 1.0) * span
        if lowest < 0.0:  # a knob, so that the middle can be seen too
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

    def _draw_help(self, screen):
        panel = pygame.Surface((390, 2 * _MARGIN + _ROW * len(HELP)), pygame.SRCALPHA)
        panel.fill((0, 0, 0, 180))
        for row, (keys, what) in enumerate(HELP):
            panel.blit(self._font.render(keys, True, _LIT), (_MARGIN, _MARGIN + _ROW * row))
            panel.blit(self._font.render(what, True, _TEXT), (_MARGIN + 90, _MARGIN + _ROW * row))
        screen.blit(panel, panel.get_rect(centerx=(screen.get_width() + _WIDTH) // 2, top=60))

    def _draw_notices(self, screen, notices):
        y = screen.get_height() - _MARGIN
        for text, strength in reversed(notices):
            line = self._large.render(text, True, _TEXT)
            plate = pygame.Surface((line.get_width() + 24, line.get_height() + 12), pygame.SRCALPHA)
            plate.fill((0, 0, 0, 170))
            plate.blit(line, (12, 6))
            plate.set_alpha(round(255 * strength))
            y -= plate.get_height() + 4
            screen.blit(plate, plate.get_rect(centerx=(screen.get_width() + _WIDTH) // 2, top=y))
