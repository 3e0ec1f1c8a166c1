"""Pictures in memory that several processes share."""

from __future__ import annotations

from multiprocessing.shared_memory import SharedMemory

import numpy as np

from sdc_sim.camera.camera_model import CameraModel

# The background may be so many pictures ahead of the objects, plus the one that it paints.
SLOTS = 6


class SharedPictures:
    """Room for SLOTS pictures.

    The process that creates it also removes it, with `remove`. If that process is killed,
    the resource tracker of multiprocessing does so.

    Attributes:
        pictures: BGRA pictures (SLOTS, height, width, 4) uint8
        name: name by which other processes attach
    """

    def __init__(self, camera: CameraModel, name: str | None = None):
        """Create the memory, or attach to the one of this name."""
        shape = (SLOTS, camera.height, camera.width, 4)
        size = SLOTS * camera.height * camera.width * 4
        memory = SharedMemory(name, create=name is None, size=size)
        # The array must be released before the memory is: attributes are, in this order.
        self.pictures: np.ndarray = np.ndarray(shape, np.uint8, memory.buf)
        self.name = memory.name
        self._memory = memory

    def remove(self) -> None:
        """Remove the memory; processes that are attached keep it until they end."""
        self._memory.unlink()
