"""Pictures for the page: at a limited rate, each encoded once for all viewers."""

from __future__ import annotations

import cv2
import numpy as np
from sensor_msgs.msg import Image

from sdc_common.ros.pictures import pixels_of
from sdc_common.validation import check_positive

# A picture that is early by this share of the period is not too early: pictures arrive unevenly.
_EARLY_SHARE = 0.4
# How often the speed of simulated time is measured [s], and from which speed on it is lockstep.
_MEASURE_EVERY_S = 0.5
_FASTER = 1.5


class RateLimit:
    """Admits events at a largest mean rate.

    Raises:
        ValueError: the rate is not positive
    """

    def __init__(self, per_second: float):
        check_positive(per_second=per_second)
        self._period_s = 1.0 / per_second
        self._due_s = 0.0

    def admits(self, now_s: float) -> bool:
        """Return whether an event at this time is admitted."""
        if now_s < self._due_s - _EARLY_SHARE * self._period_s:
            return False
        self._due_s = max(self._due_s, now_s - self._period_s) + self._period_s
        return True


class DriveSpeed:
    """Measures whether simulated time is faster than real time, as in lockstep."""

    def __init__(self) -> None:
        self.is_lockstep = False
        self._measured_at = (0.0, 0.0)

    def add(self, now_s: float, stamp_s: float) -> None:
        """Add the arrival of a message with this stamp."""
        elapsed_s = now_s - self._measured_at[0]
        if elapsed_s >= _MEASURE_EVERY_S:
            self.is_lockstep = stamp_s - self._measured_at[1] > _FASTER * elapsed_s
            self._measured_at = (now_s, stamp_s)


def jpeg_file(message: Image, quality: float) -> bytes:
    """Return a camera picture as a JPEG file of a quality of 1 to 100.

    Raises:
        ValueError: the picture is not valid
    """
    return _encoded(".jpg", pixels_of(message), [cv2.IMWRITE_JPEG_QUALITY, int(quality)])


def mask_png(message: Image) -> bytes:
    """Return a lane mask as a PNG file with one bit for each pixel.

    Raises:
        ValueError: the mask is not valid
    """
    options = [cv2.IMWRITE_PNG_BILEVEL, 1, cv2.IMWRITE_PNG_COMPRESSION, 1]
    return _encoded(".png", pixels_of(message, "mono8"), options)


def _encoded(ending: str, pixels: np.ndarray, options: list) -> bytes:
    try:
        return cv2.imencode(ending, pixels, options)[1].tobytes()
    except cv2.error as error:
        raise ValueError(str(error)) from error
