"""Finds lane markings in a camera picture: gradient and saturation thresholds, combined to a binary mask."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from sdc_common.validation import check_between


@dataclass(frozen=True)
class LaneFilterThresholds:
    """What counts as a marking. The horizon row and those above are never searched."""

    gradient: int
    saturation: int
    lightness: int
    horizon_fraction: float

    def __post_init__(self):
        check_between(
            0, 255, gradient=self.gradient, saturation=self.saturation, lightness=self.lightness
        )
        check_between(0.0, 0.99, horizon_fraction=self.horizon_fraction)


class LaneFilter:
    """Marks steep horizontal gradients (Sobel) and saturated bright colours (HLS) in a picture.

    The gradient is normalised by the strongest one in the picture, so that dusk and noon look alike; a picture without
    any edge (black, uniform) gives an empty mask. Thresholds act on 0..255.
    Source: the combined threshold lesson of lane finding; OpenCV 4 reference, `Sobel` and `COLOR_BGR2HLS`.
    """

    # Below this a picture's strongest gradient is sensor noise: normalising by it would paint noise white.
    FAINTEST_EDGE = 24

    def __init__(self, thresholds: LaneFilterThresholds):
        self.thresholds = thresholds

    def mask(self, image: np.ndarray) -> np.ndarray:
        """Return the markings of a (H, W, 3) BGR or (H, W, 4) BGRA uint8 picture as a (H, W) uint8 mask of 0 and 255.

        Raises ValueError for an array of another shape or type.
        """
        if (
            image.dtype != np.uint8
            or image.ndim != 3
            or image.shape[2] not in (3, 4)
            or 0 in image.shape
        ):
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
        gray = cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY)
        gradient = cv2.Sobel(gray, cv2.CV_16S, 1, 0, ksize=3)
        lowest, highest, _, _ = cv2.minMaxLoc(gradient)
        strongest = max(highest, -lowest)
        if strongest < self.FAINTEST_EDGE:
            return np.zeros(gray.shape, np.uint8)
        scaled = cv2.convertScaleAbs(gradient, alpha=255.0 / strongest)
        return cv2.threshold(scaled, self.thresholds.gradient, 255, cv2.THRESH_BINARY)[1]

    def _colourful(self, bgr: np.ndarray) -> np.ndarray:
        hls = cv2.cvtColor(bgr, cv2.COLOR_BGR2HLS)
        low = (0, self.thresholds.lightness, self.thresholds.saturation)
        return cv2.inRange(hls, low, (255, 255, 255))
