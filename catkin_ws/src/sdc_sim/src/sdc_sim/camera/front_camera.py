"""The world's side of the front camera: tells the process that takes the pictures what stands where."""

from __future__ import annotations

import sys

import rospy

from sdc_sim.camera.side_process import SideProcess
from sdc_sim.simulation.simulation import Observation

# In lockstep the world may run so many pictures ahead, which evens out the dear ones, and waits so long for one.
_AHEAD = 6
_PATIENCE_S = 2.0


class FrontCamera:
    """Shows Snapshots to the camera; in lockstep every one of them, else those that it has time for.

    daylight: 0..1, brightness of the picture.
    """

    def __init__(
        self,
        waypoints_path: str,
        image_topic: str,
        camera_info_topic: str,
        daylight: float,
        every_frame: bool,
    ):
        remappings = [
            argument
            for argument in sys.argv[1:]
            if ":=" in argument and not argument.startswith("__")
        ]
        command = [
            sys.executable,
            "-m",
            "sdc_sim.camera.backdrop_painter",
            waypoints_path,
            image_topic,
            camera_info_topic,
            str(daylight),
            *remappings,
        ]
        self._process = SideProcess(
            command, _AHEAD, lambda problem: rospy.logwarn("sim: the camera's process %s", problem)
        )
        self._every_frame = every_frame
        rospy.on_shutdown(self._process.close)

    def show(self, sensed: Observation) -> None:
        """One tick of the world."""
        state = sensed.state
        scene = [sensed.stamp, state.x_m, state.y_m, state.yaw_rad, sensed.bodies, sensed.lamps]
        if self._every_frame:
            self._process.put(scene, _PATIENCE_S)
        else:
            self._process.offer(scene)
