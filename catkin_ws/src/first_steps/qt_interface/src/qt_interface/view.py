"""The transformation between field and screen: the visible part of the field and its scale."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

SCALE_MIN, SCALE_MAX = 0.02, 40.0  # pixels per field unit


class View(NamedTuple):
    """The visible part of the field.

    `centre_x`, `centre_y` is the field point in the middle of the widget [u], `scale` is in pixels
    per field unit, `width` and `height` are the widget's size [pixels]. On the field y points up,
    on the screen down.
    """

    centre_x: float
    centre_y: float
    scale: float
    width: int
    height: int

    def to_pixel(self, x: float, y: float) -> tuple[float, float]:
        """Return the pixel of the widget that shows the field point (x, y) [u]."""
        return (
            self.width / 2.0 + (x - self.centre_x) * self.scale,
            self.height / 2.0 - (y - self.centre_y) * self.scale,
        )

    def to_field(self, pixel_x: float, pixel_y: float) -> tuple[float, float]:
        """Return the field point [u] that the pixel shows."""
        return (
            self.centre_x + (pixel_x - self.width / 2.0) / self.scale,
            self.centre_y - (pixel_y - self.height / 2.0) / self.scale,
        )

    def zoomed(self, factor: float, pixel_x: float, pixel_y: float) -> View:
        """Return the view scaled by `factor`; the field point at the pixel stays there."""
        scale = min(max(self.scale * factor, SCALE_MIN), SCALE_MAX)
        share = 1.0 - self.scale / scale
        x, y = self.to_field(pixel_x, pixel_y)
        return self._replace(
            centre_x=self.centre_x + (x - self.centre_x) * share,
            centre_y=self.centre_y + (y - self.centre_y) * share,
            scale=scale,
        )

    def panned(self, pixels_x: float, pixels_y: float) -> View:
        """Return the view after the field was dragged by this number of pixels."""
        return self._replace(
            centre_x=self.centre_x - pixels_x / self.scale,
            centre_y=self.centre_y + pixels_y / self.scale,
        )


def fit(points: Sequence[tuple[float, float]], width: int, height: int, margin: int) -> View:
    """Return the view that shows all points.

    Args:
        points: field points (x, y) [u]
        width: width of the widget [pixels]
        height: height of the widget [pixels]
        margin: smallest distance of a point from the widget's edges [pixels]
    """
    xs, ys = [x for x, _ in points] or [0.0], [y for _, y in points] or [0.0]
    room_x, room_y = max(width - 2 * margin, 1), max(height - 2 * margin, 1)
    scale = min(room_x / max(max(xs) - min(xs), 1.0), room_y / max(max(ys) - min(ys), 1.0), 1e9)
    scale = min(max(scale, SCALE_MIN), SCALE_MAX)
    return View((min(xs) + max(xs)) / 2.0, (min(ys) + max(ys)) / 2.0, scale, width, height)


def nice_step(length: float) -> float:
    """Return the largest of 1, 2, 5, 10, 20, 50, ... that is at most `length`."""
    power = 10.0 ** math.floor(math.log10(length))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length * (1.0 + 1e-9))
