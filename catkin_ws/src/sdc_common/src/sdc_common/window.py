"""A window that shows a camera picture."""

from __future__ import annotations

import os

import numpy as np

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
import pygame  # noqa: E402  the line above must stand before it

_FRAMES_PER_SECOND = 30
# What SDL falls back to where there is no display: windows that nobody sees.
_UNSEEN = ("offscreen", "dummy")


class NoDisplay(Exception):
    """There is no display to open a window on."""


class ImageWindow:
    """Shows BGR pictures and hands back the keys that were pressed. Raises NoDisplay where there is none.

    `held` is the set of the names of the keys that are down, `step_s` the time that the last picture was shown, in seconds.
    """

    def __init__(self, title: str, size=(640, 480), frames_per_second: float = _FRAMES_PER_SECOND):
        self._screen = self._open(title, size)
        self._clock = pygame.time.Clock()
        self._frames_per_second = frames_per_second
        self._surface = None
        self.closed = False
        self.held = set()
        self.step_s = 0.0

    @staticmethod
    def _open(title, size):
        display, chosen = os.environ.get("DISPLAY", ""), "SDL_VIDEODRIVER" in os.environ
        missing = f"there is no display to open a window on (DISPLAY={display!r})"
        if not (display or chosen or "WAYLAND_DISPLAY" in os.environ):
            raise NoDisplay(missing)
        if "WAYLAND_DISPLAY" not in os.environ:
            os.environ.setdefault("SDL_VIDEODRIVER", "x11")
        try:
            pygame.display.init()
            if chosen or pygame.display.get_driver() not in _UNSEEN:
                pygame.display.set_caption(title)
                return pygame.display.set_mode(size)
        except pygame.error as error:
            raise NoDisplay(f"{missing}: {error}") from error
        pygame.display.quit()
        raise NoDisplay(missing)

    @property
    def frame_rate(self) -> float:
        """Pictures shown per second, over the last ten."""
        return self._clock.get_fps()

    def show(self, picture, overlay=None):
        """Show a (H, W, 3) BGR uint8 picture, or what was shown last if it is None, until the next is due; returns the names of
        the keys pressed meanwhile. `overlay(screen)` draws on top of it."""
        keys = self._pressed_keys()
        if self.closed:
            return keys
        if picture is not None:
            if picture.shape[1::-1] != self._screen.get_size():
                self._screen = pygame.display.set_mode(picture.shape[1::-1])
            rgb = np.ascontiguousarray(picture[:, :, ::-1])
            self._surface = pygame.image.frombuffer(rgb.tobytes(), picture.shape[1::-1], "RGB")
        if self._surface is not None:
            self._screen.blit(self._surface, (0, 0))
        else:
            self._screen.fill(0)
        if overlay is not None:
            overlay(self._screen)
        pygame.display.flip()
        self.step_s = self._clock.tick(self._frames_per_second) / 1000.0
        return keys

    def _pressed_keys(self):
        keys = []
        for event in pygame.event.get():
            if event.type == pygame.QUIT:
                self.close()
                return keys
            if event.type == pygame.KEYDOWN:
                keys.append(pygame.key.name(event.key))
                self.held.add(pygame.key.name(event.key))
            elif event.type == pygame.KEYUP:
                self.held.discard(pygame.key.name(event.key))
            elif event.type == getattr(
                pygame, "WINDOWFOCUSLOST", None
            ):  # pygame 1.9 knows no such event
                self.held.clear()
        return keys

    def close(self) -> None:
        """Close the window; the node goes on without it."""
        if not self.closed:
            self.closed = True
            self.held.clear()
            pygame.display.quit()
