"""A window that shows a camera picture."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

# pygame reads the variable when it is imported.
os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
# Debian 13 builds pygame without instructions that some processors have.
warnings.filterwarnings("ignore", "Your system is avx2 capable", RuntimeWarning)
import pygame  # noqa: E402


class NoDisplay(Exception):
    """There is no display to open a window on."""


class ImageWindow:
    """Shows BGR pictures and returns the keys that were pressed."""

    def __init__(self, title: str, frames_per_second: float = 30.0):
        """Open a window, whose method `show` takes at least the period of a frame.

        Raises:
            NoDisplay: there is no display
        """
        self.clock = pygame.time.Clock()  # measures the time between pictures
        self._frames_per_second: Any = frames_per_second
        self.closed = False
        # Names of the keys that are down; without the focus, no key is
        self.held: set[str] = set()
        display = os.environ.get("DISPLAY", "")
        # Without a display, SDL would select a driver whose windows are invisible.
        wayland = "WAYLAND_DISPLAY" in os.environ and not display
        os.environ.setdefault("SDL_VIDEODRIVER", "wayland" if wayland else "x11")
        try:
            pygame.display.init()
            pygame.display.set_caption(title)
            self._screen: Any = pygame.display.set_mode((640, 480))
        except pygame.error as error:
            raise NoDisplay(
                f"there is no display to open a window on (DISPLAY={display!r}): {error}"
            ) from error

    def show(
        self, picture: np.ndarray | None, overlay: Callable[[pygame.Surface], None] | None = None
    ) -> list[str]:
        """Show a picture until the next one is due; return the names of the pressed keys.

        Args:
            picture: (H, W, 3) BGR uint8, or None for a black screen
            overlay: draws on the screen, over the picture
        """
        keys = [] if self.closed else self._pressed_keys()
        if self.closed:
            return keys
        if picture is not None:
            size = picture.shape[1], picture.shape[0]
            if size != self._screen.get_size():
                self._screen = pygame.display.set_mode(size)
            rgb = picture[:, :, ::-1].tobytes()
            self._screen.blit(pygame.image.frombuffer(rgb, size, "RGB"), (0, 0))
        else:
            self._screen.fill(0)
        if overlay is not None:
            overlay(self._screen)
        pygame.display.flip()
        self.clock.tick(self._frames_per_second)
        return keys

    def _pressed_keys(self) -> list[str]:
        keys: list[str] = []
        for event in pygame.event.get():
            if event.type == pygame.QUIT:
                self.close()
                return keys
            if event.type == pygame.KEYDOWN:
                keys.append(pygame.key.name(event.key))
                self.held.add(pygame.key.name(event.key))
            elif event.type == pygame.KEYUP:
                self.held.discard(pygame.key.name(event.key))
        return keys

    def close(self) -> None:
        """Close the window; further calls of `show` do nothing."""
        if not self.closed:
            self.closed = True
            self.held.clear()
            pygame.display.quit()
