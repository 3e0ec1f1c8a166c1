"""Pictures in memory that two processes share."""

from __future__ import annotations

import mmap
import os

import numpy as np

from sdc_sim.camera.camera_model import CameraModel

# One is painted while the others wait for their turn.
SLOTS = 6


def create() -> int:
    """The number of an open file with room for SLOTS pictures, to be inherited; it vanishes with its last user."""
    number = os.memfd_create("pictures")
    os.truncate(number, _bytes(CameraModel()) * SLOTS)
    return number


def pictures(number: int) -> np.ndarray:
    """The pictures (SLOTS, height, width, 4) uint8 in the file that `create` made."""
    camera = CameraModel()
    return np.frombuffer(mmap.mmap(number, _bytes(camera) * SLOTS), np.uint8).reshape(
        SLOTS, camera.height, camera.width, 4
    )


def _bytes(camera: CameraModel) -> int:
    return camera.height * camera.width * 4
