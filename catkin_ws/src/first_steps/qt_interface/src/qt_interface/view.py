"""From the field to the screen and back: which part of the field is seen, and how large."""

from __future__ import annotations

import math
from typing import NamedTuple

SCALE_MIN, SCALE_MAX = 0.02, 40.0  # pixels per field unit


class View(NamedTuple):
    """The field point in the middle of the widget, pixels per field unit, and the widget's size in pixels.

    On the field y points up, on the screen down.
    """

    centre_x: float
    centre_y: float
    scale: float
    width: int
    height: int

    def to_pixel(self, x, y):
        """Where on the widget the field point lies, pixels."""
        return (
            self.width / 2.0 + (x - self.centre_x) * self.scale,
            self.height / 2.0 - (y - self.centre_y) * self.scale,
        )

    def to_field(self, pixel_x, pixel_y):
        """Which field point lies under the pixel, field units."""
        return (
            self.centre_x + (pixel_x - self.width / 2.0) / self.scale,
            self.centre_y - (pixel_y - self.height / 2.0) / self.scale,
        )

    def zoomed(self, factor, pixel_x, pixel_y):
        """A view `factor` times as large; the field point under the pixel stays under it."""
        scale = min(max(self.scale * factor, SCALE_MIN), SCALE_MAX)
        kept = 1.0 - self.scale / scale
        x, y = self.to_field(pixel_x, pixel_y)
        return self._replace(
            centre_x=self.centre_x + (x - self.centre_x) * kept,
            centre_y=self.centre_y + (y - self.centre_y) * kept,
            scale=scale,
        )

    def panned(self, pixels_x, pixels_y):
        """The view after the field was dragged by so many pixels."""
        return self._replace(
            centre_x=self.centre_x - pixels_x / self.scale,
            centre_y=self.centre_y + pixels_y / self.scale,
        )


def fit(points, width, height, margin):
    """The view on a widget of width x height pixels that shows all `points`, `margin` pixels from its edges."""
    xs, ys = [x for x, _ in points] or [0.0], [y for _, y in points] or [0.0]
    room_x, room_y = max(width - 2 * margin, 1), max(height - 2 * margin, 1)
    scale = min(room_x / max(max(xs) - min(xs), 1.0), room_y / max(max(ys) - min(ys), 1.0), 1e9)
    scale = min(max(scale, SCALE_MIN), SCALE_MAX)
    return View((min(xs) + max(xs)) / 2.0, (min(ys) + max(ys)) / 2.0, scale, width, height)


def nice_step(length):
    """The largest of 1, 2, 5, 10, 20, 50, ... that is at most `length`: the spacing of a grid's lines."""
    power = 10.0 ** math.floor(math.log10(length))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length * (1.0 + 1e-9))
