"""Front camera of the simulation: hands observations to the processes that publish the pictures."""

from __future__ import annotations

from typing import Any, Callable

import rospy

from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.shared_pictures import SharedPictures
from sdc_sim.camera.worker_process import WorkerProcess
from sdc_sim.simulation.simulation import Observation

# In lockstep the simulation may be so many pictures ahead, which evens out their render times.
_DEPTH = 6
_TIMEOUT_S = 2.0


class FrontCamera:
    """The camera of the simulated car.

    In lockstep it publishes a picture of every observation; in real time it drops observations
    while the previous picture is being rendered.
    """

    def __init__(
        self,
        waypoints_path: str,
        image_topic: str,
        camera_info_topic: str,
        daylight: float,
        every_frame: bool,
    ):
        """Start the processes; they end when the node shuts down.

        Args:
            waypoints_path: CSV file of the route
            image_topic: topic of the picture
            camera_info_topic: topic of the camera_info
            daylight: brightness of the picture, 0..1
            every_frame: whether to publish every observation (lockstep)
        """
        self._shared = SharedPictures(CameraModel())
        self._process = WorkerProcess(
            _start_painter,
            (waypoints_path, self._shared.name, image_topic, camera_info_topic, daylight),
            _DEPTH,
            lambda problem: rospy.logwarn("sim: the camera's process %s", problem),
        )
        self._every_frame = every_frame
        rospy.on_shutdown(self._close)

    def show(self, observation: Observation) -> None:
        """Hand over one observation to be rendered and published."""
        if self._every_frame:
            self._process.put(observation, _TIMEOUT_S)
        else:
            self._process.offer(observation)

    def _close(self) -> None:
        self._process.close()
        self._shared.remove()


def _start_painter(waypoints_path: str, *arguments: Any) -> Callable[[Observation], None]:
    # The simulation imports this module, but does not need OpenCV and the renderer.
    from sdc_sim.camera.camera_node import BackgroundPainter

    return BackgroundPainter(waypoints_path, *arguments).paint
