"""Compare the lane filter with a plain OpenCV version, on one core.

python3 -m sdc_experiments.benchmark_lane_filter
"""

from __future__ import annotations

import time
from typing import Callable

import cv2
import numpy as np

from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds

_FRAMES = 300


def plain_mask(image: np.ndarray) -> np.ndarray:
    """Return the lane mask of a BGRA picture as a textbook computes it.

    It uses a floating-point gradient, the whole picture, and masks that NumPy combines.
    """
    bgr = image[:, :, :3]
    gradient = np.absolute(cv2.Sobel(cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY), cv2.CV_64F, 1, 0))
    scaled = np.asarray(255 * gradient / max(gradient.max(), 1.0), dtype=np.uint8)
    saturation = cv2.cvtColor(bgr, cv2.COLOR_BGR2HLS)[:, :, 2]
    mask = np.zeros_like(saturation)
    mask[((scaled >= 70) & (scaled <= 255)) | ((saturation >= 90) & (saturation <= 255))] = 255
    return mask


def median_ms(function: Callable[[np.ndarray], np.ndarray], image: np.ndarray) -> float:
    """Return the median time of a call [ms]."""
    times = []
    for _ in range(_FRAMES):
        start = time.perf_counter()
        function(image)
        times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times))


def main() -> None:
    """Measure both and print their times and ratio."""
    cv2.setNumThreads(1)
    image = np.random.default_rng(0).integers(0, 255, (480, 640, 4), dtype=np.uint8)
    thresholds = LaneFilterThresholds(
        gradient=70, saturation=90, lightness=110, horizon_fraction=0.52
    )
    own_ms, plain_ms = median_ms(LaneFilter(thresholds).mask, image), median_ms(plain_mask, image)
    print(
        f"lane filter, 640 x 480, one thread: {own_ms:.2f} ms per frame; "
        f"plain version {plain_ms:.2f} ms; ratio {plain_ms / own_ms:.1f}"
    )


if __name__ == "__main__":
    main()
