"""The first of the two processes behind the front camera: paints sky and ground, then hands the picture to the photographer."""

from __future__ import annotations

import signal
import sys

import cv2

from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.camera import shared_pictures
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.renderer import Backdrop
from sdc_sim.camera.side_process import SideProcess, give_way, serve
from sdc_sim.road.road import Road

_PATIENCE_S = 2.0


class BackdropPainter:
    """Paints behind the scenes that FrontCamera shows."""

    def __init__(self, waypoints_path: str, *arguments: str):
        number = shared_pictures.create()
        command = [
            sys.executable,
            "-m",
            "sdc_sim.camera.photographer",
            waypoints_path,
            *arguments,
            str(number),
        ]
        self.photographer = SideProcess(
            command, shared_pictures.SLOTS - 1, self.warn, files=[number]
        )
        self.backdrop = Backdrop(Road(load_waypoints(waypoints_path)), CameraModel())
        self.pictures = shared_pictures.pictures(number)
        self.slot = 0

    def take(self, scene) -> None:
        """Paint one scene's backdrop and hand it on."""
        _, x, y, yaw, *_ = scene
        self.backdrop.draw(self.pictures[self.slot], x, y, yaw)
        if self.photographer.put([self.slot, *scene], _PATIENCE_S):
            self.slot = (self.slot + 1) % shared_pictures.SLOTS

    @staticmethod
    def warn(problem: str) -> None:
        """Say what became of the photographer."""
        print(f"sim: the photographer's process {problem}", file=sys.stderr, flush=True)


def main():
    """Serve until the world closes or ends: an interrupt from the keyboard is the world's to hear."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    give_way()
    cv2.setNumThreads(1)
    *arguments, socket_number = sys.argv[1:]
    painter = BackdropPainter(*arguments)
    serve(int(socket_number), painter.take)
    painter.photographer.close()


if __name__ == "__main__":
    main()
