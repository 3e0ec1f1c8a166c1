"""A window that shows a camera picture."""
from __future__ import annotations

import os

import numpy as np

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
import pygame  # noqa: E402  the line above must stand before it

_FRAMES_PER_SECOND = 30


class Window:
    """Shows BGR pictures and hands back the keys that were pressed. Raises pygame.error where there is no display."""

    def __init__(self, title: str, size=(640, 480)):
        pygame.display.init()
        pygame.display.set_caption(title)
        self._screen = pygame.display.set_mode(size)
        self._clock = pygame.time.Clock()
        self.closed = False

    def show(self, picture):
        """Show a (H, W, 3) BGR uint8 picture, or what was shown last if it is None, for a thirtieth of a second; returns the
        names of the keys pressed meanwhile."""
        keys = []
        for event in pygame.event.get():
            if event.type == pygame.QUIT:
                self.close()
                return keys
            if event.type == pygame.KEYDOWN:
                keys.append(pygame.key.name(event.key))
        if picture is not None:
            if picture.shape[1::-1] != self._screen.get_size():
                self._screen = pygame.display.set_mode(picture.shape[1::-1])
            rgb = np.ascontiguousarray(picture[:, :, ::-1])
            surface = pygame.image.frombuffer(rgb.tobytes(), picture.shape[1::-1], "RGB")
            self._screen.blit(surface, (0, 0))
        pygame.display.flip()
        self._clock.tick(_FRAMES_PER_SECOND)
        return keys

    def close(self) -> None:
        """Close the window; the node goes on without it."""
        if not self.closed:
            self.closed = True
            pygame.display.quit()
