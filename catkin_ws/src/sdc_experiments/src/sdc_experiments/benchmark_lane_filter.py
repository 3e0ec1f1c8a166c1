"""Times the lane filter on one core beside a plain OpenCV form of it: python3 -m sdc_experiments.benchmark_lane_filter"""

from __future__ import annotations

import time

import cv2
import numpy as np

from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds

_FRAMES = 300


def plain_form(image: np.ndarray) -> np.ndarray:
    """The filter as lessons write it: floating-point gradient, whole picture, masks combined in NumPy."""
    bgr = image[:, :, :3]
    gradient = np.absolute(cv2.Sobel(cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY), cv2.CV_64F, 1, 0))
    scaled = np.uint8(255 * gradient / max(gradient.max(), 1.0))
    saturation = cv2.cvtColor(bgr, cv2.COLOR_BGR2HLS)[:, :, 2]
    mask = np.zeros_like(saturation)
    mask[((scaled >= 70) & (scaled <= 255)) | ((saturation >= 90) & (saturation <= 255))] = 255
    return mask


def median_ms(function, image: np.ndarray) -> float:
    """Median time of a call in milliseconds."""
    times = []
    for _ in range(_FRAMES):
        start = time.perf_counter()
        function(image)
        times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times))


def main() -> None:
    cv2.setNumThreads(1)
    image = np.random.default_rng(0).integers(0, 255, (480, 640, 4), dtype=np.uint8)
    lane_filter = LaneFilter(
        LaneFilterThresholds(gradient=70, saturation=90, lightness=110, horizon_fraction=0.52)
    )
    ours, plain = median_ms(lane_filter.mask, image), median_ms(plain_form, image)
    print(
        f"lane filter, 640 x 480, one thread: {ours:.2f} ms a frame; plain form {plain:.2f} ms; ratio {plain / ours:.1f}"
    )


if __name__ == "__main__":
    main()
