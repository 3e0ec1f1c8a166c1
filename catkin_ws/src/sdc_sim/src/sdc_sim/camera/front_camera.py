"""Cameras of the simulation: hand observations to the processes that publish the pictures."""

from __future__ import annotations

from typing import Any, Callable

import rospy

from sdc_sim.camera.camera_input import CameraInput
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.shared_pictures import SharedPictures
from sdc_sim.camera.worker_process import WorkerProcess
from sdc_sim.ros.bridge_generations import BridgeGeneration
from sdc_sim.simulation.observation import Observation

# In lockstep the simulation may be so many pictures ahead, which evens out their render times.
_DEPTH = 6
_TIMEOUT_S = 10.0


class FrontCamera:
    """The front camera of the simulated car, and the cameras behind it and of a spectator.

    In lockstep it publishes a picture of every observation; in real time it drops observations
    while the previous picture is being rendered.
    """

    def __init__(
        self,
        waypoints_path: str,
        role_name: str,
        generation: BridgeGeneration,
        daylight: float,
        every_frame: bool,
        weather: dict[str, Any] | None = None,
    ):
        """Start the processes; they end when the node shuts down.

        Args:
            waypoints_path: CSV file of the route
            role_name: name of the vehicle in topics and frames
            generation: names of the cameras
            daylight: brightness of the pictures, 0..1
            every_frame: whether to publish every observation (lockstep)
            weather: fields of Weather, None for clear weather
        """
        self.daylight = daylight
        self.spectator: tuple[float, float, float, float, float] | None = None
        self._shared = SharedPictures(CameraModel())
        self._process = WorkerProcess(
            _start_painter,
            (
                waypoints_path,
                self._shared.name,
                role_name,
                generation,
                *([weather] if weather else []),
            ),
            _DEPTH,
            lambda problem: rospy.logwarn("sim: the camera's process %s", problem),
            # In real time a picture may be dropped, but the control loop is not to be late.
            idle=not every_frame,
        )
        self._every_frame = every_frame
        rospy.on_shutdown(self._close)

    def show(self, observation: Observation, again: bool = False) -> None:
        """Hand over one observation to be rendered and published.

        Args:
            observation: the observation
            again: whether it has been handed over before; it is then dropped if the camera is busy
        """
        shot = CameraInput(observation, self.daylight, self.spectator)
        if self._every_frame and not again:
            self._process.put(shot, _TIMEOUT_S)
        else:
            self._process.offer(shot)

    def _close(self) -> None:
        self._process.close()
        self._shared.remove()


def _start_painter(waypoints_path: str, *arguments: Any) -> Callable[[CameraInput], None]:
    # The simulation imports this module, but does not need OpenCV and the renderer.
    from sdc_sim.camera.camera_node import BackgroundPainter

    return BackgroundPainter(waypoints_path, *arguments).paint
