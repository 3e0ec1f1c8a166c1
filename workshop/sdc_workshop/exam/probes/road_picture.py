"""A picture of a road with known markings."""

import numpy as np


def road(first: int = 300, width: int = 10) -> np.ndarray:
    """Return a picture with a white and a yellow line, a red and a blue stripe, and a bright sign.

    The yellow line begins at the column `first`, with a width [pixels]; (480, 640, 4) uint8, BGRA.
    """
    picture = np.full((480, 640, 4), (80, 80, 80, 255), np.uint8)
    picture[:240] = (150, 90, 30, 255)
    picture[100:140, 500:560, :3] = (20, 220, 240)
    picture[250:, 100:110, :3] = 255
    picture[250:, first : first + width, :3] = (20, 200, 230)
    picture[250:, 400:440, :3] = (0, 0, 215)
    picture[250:, 500:540, :3] = (215, 0, 0)
    return picture
