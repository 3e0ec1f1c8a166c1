"""Reads the pixels out of a sensor_msgs/Image."""
from __future__ import annotations

import numpy as np
from cv_bridge import CvBridge, CvBridgeError

_BRIDGE = CvBridge()


def bgra_pixels(message) -> np.ndarray:
    """The picture as (height, width, 4) uint8: blue, green, red, alpha. Raises ValueError for an encoding that cannot be turned
    into these, for a size of nothing, and for data that are not of the size that the message tells."""
    fits = 0 < message.width <= message.step and 0 < message.height * message.step <= len(message.data)
    if not fits:
        raise ValueError(f"{message.width} x {message.height} pixels in rows of {message.step} bytes do not come with {len(message.data)} bytes")
    try:
        pixels = _BRIDGE.imgmsg_to_cv2(message, "bgra8")
    except (CvBridgeError, TypeError, ValueError) as error:
        raise ValueError(f"'{message.encoding}' of {message.width} x {message.height} pixels cannot be shown in colours ({error})") from error
    if pixels is None:
        raise ValueError(f"'{message.encoding}' of {message.width} x {message.height} pixels cannot be shown in colours")
    return pixels
