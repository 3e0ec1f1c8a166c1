"""Find lane markings in a camera picture with thresholds on gradient and saturation."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from sdc_common.validation import check_between


@dataclass(frozen=True)
class LaneFilterThresholds:
    """Thresholds of a lane marking."""

    gradient: int  # minimum horizontal gradient, 255 is the strongest in the picture
    saturation: int  # minimum HLS saturation of a coloured marking, 0..255
    lightness: int  # minimum HLS lightness of a coloured marking, 0..255
    # Share of the picture's height, from the top, that contains no markings
    horizon_fraction: float

    def __post_init__(self):
        check_between(
            0, 255, gradient=self.gradient, saturation=self.saturation, lightness=self.lightness
        )
        check_between(0.0, 0.99, horizon_fraction=self.horizon_fraction)


class LaneFilter:
    """A filter for steep horizontal gradients (Sobel) and saturated bright colours (HLS).

    The gradient is normalized by the strongest one in the picture, so that dusk and noon give the
    same mask.

    Reference: OpenCV 4 documentation, `Sobel` and `COLOR_BGR2HLS`.
    """

    # A weaker maximum is sensor noise: normalizing by it would turn noise into markings.
    MIN_EDGE = 24

    def __init__(self, thresholds: LaneFilterThresholds):
        self.thresholds = thresholds

    def mask(self, image: np.ndarray) -> np.ndarray:
        """Return the markings in a picture.

        Args:
            image: (H, W, 3) BGR or (H, W, 4) BGRA uint8

        Returns:
            (H, W) uint8, 255 on markings, 0 elsewhere

        Raises:
            ValueError: the array has another shape or type
        """
        is_picture = image.ndim == 3 and image.shape[2] in (3, 4) and 0 not in image.shape
        if image.dtype != np.uint8 or not is_picture:
            raise ValueError(
                f"expected a (H, W, 3 or 4) uint8 picture, got {image.shape} {image.dtype}"
            )
        mask = np.zeros(image.shape[:2], np.uint8)
        top = int(image.shape[0] * self.thresholds.horizon_fraction)
        road = image[top:]
        bgr = cv2.cvtColor(road, cv2.COLOR_BGRA2BGR) if road.shape[2] == 4 else road
        # TODO 5: below the horizon, a pixel is a marking where the picture is steep or colourful
        mask[top:] = cv2.bitwise_or(self._steep(bgr), self._colourful(bgr))
        # ------------------------------------------------------------------------
        return mask

    def _steep(self, bgr: np.ndarray) -> np.ndarray:
        """Return a mask of the steep horizontal gradients, which the sides of a marking have."""
        gray = cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY)
        gradient = cv2.Sobel(gray, cv2.CV_16S, 1, 0, ksize=3)
        lowest, highest, _, _ = cv2.minMaxLoc(gradient)
        strongest = max(highest, -lowest)
        if strongest < self.MIN_EDGE:
            return np.zeros(gray.shape, np.uint8)
        scaled = cv2.convertScaleAbs(gradient, alpha=255.0 / strongest)
        return cv2.threshold(scaled, self.thresholds.gradient, 255, cv2.THRESH_BINARY)[1]

    def _colourful(self, bgr: np.ndarray) -> np.ndarray:
        """Return a mask of the bright saturated pixels, such as those of a yellow marking."""
        hls = cv2.cvtColor(bgr, cv2.COLOR_BGR2HLS)
        low = (0, self.thresholds.lightness, self.thresholds.saturation)
        return cv2.inRange(hls, low, (255, 255, 255))
