"""The pixels of pictures that are received."""

from __future__ import annotations

import numpy as np
from cv_bridge import CvBridge, CvBridgeError
from sensor_msgs.msg import Image

from sdc_common.ros.conversion import check_image

_BRIDGE = CvBridge()


def pixels_of(message: Image, encoding: str = "bgr8") -> np.ndarray:
    """Return the pixels of an image in an encoding.

    Raises:
        ValueError: the image is not valid, or cannot be converted
    """
    try:
        check_image(message)
        return _BRIDGE.imgmsg_to_cv2(message, encoding)
    except (CvBridgeError, TypeError) as error:
        raise ValueError(str(error)) from error
