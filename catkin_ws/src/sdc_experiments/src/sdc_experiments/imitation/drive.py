"""Let a network drive random routes that it was not trained on, in one process without ROS.

python3 -m sdc_experiments.imitation.drive NETWORK [SEED ...] prints how well.
"""

from __future__ import annotations

import argparse
import sys
import time

import cv2
import numpy as np

from sdc_common.driving import Observation, Path
from sdc_experiments.closed_loop import drive_result
from sdc_perception.imitation_network import SteeringNetwork
from sdc_perception.imitation_samples import arc_path, road_view
from sdc_sim.camera.renderer import Renderer
from sdc_sim.evaluation.drive_evaluation import DriveResult
from sdc_sim.road.random_routes import long_route
from sdc_sim.road.road import Road

# Route 1 crosses itself: a picture does not show which way to go.
SEEDS = (2, 3, 4, 5, 6)


class NetworkPlanner:
    """Plans the arc that the network answers the picture of the front camera with.

    Attributes:
        answers: the answers so far, (N, 2)
        picture_s: CPU time of each answer
    """

    def __init__(self, network: SteeringNetwork, route_m: np.ndarray):
        self.answers: list = []
        self.picture_s: list[float] = []
        self._network = network
        self._renderer = Renderer(Road(route_m))
        self._picture: np.ndarray | None = None

    def __call__(self, observation: Observation) -> Path:
        """Return the path ahead, which the picture at this pose shows."""
        pose = observation.x_m, observation.y_m, observation.yaw_rad
        self._picture = self._renderer.render(*pose, out=self._picture)
        started_s = time.thread_time()
        answer = self._network.answer(road_view(self._picture))
        rows = arc_path(pose, answer)
        self.picture_s.append(time.thread_time() - started_s)
        self.answers.append(answer)
        return Path.from_rows(rows)


def drive(
    network: SteeringNetwork, route_m: np.ndarray, left_m: float = 0.0, turned_rad: float = 0.0
) -> tuple[DriveResult, NetworkPlanner]:
    """Drive along a route that only the referee knows.

    Args:
        network: the driver
        route_m: (N, 2) waypoints [m]
        left_m: distance of the start to the left of the route [m]
        turned_rad: heading at the start relative to the route, positive left [rad]
    """
    planner = NetworkPlanner(network, route_m)
    result = drive_result(
        route=route_m,
        planner=planner,
        sim_options={"start": {"left_m": left_m, "turned_rad": turned_rad}},
        referee_options={"finish_at_rest": False},
    )
    return result, planner


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="let a steering network drive random routes")
    parser.add_argument("network", help="file of sdc_experiments.imitation.train")
    parser.add_argument("seeds", nargs="*", type=int, default=SEEDS, help="seeds of the routes")
    parser.add_argument("--least-radius", type=float, default=8.0, help="of the bends [m]")
    parser.add_argument("--left", type=float, default=0.0, help="start left of the route [m]")
    parser.add_argument("--turned", type=float, default=0.0, help="start turned to the left [rad]")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    try:
        network = SteeringNetwork.load(options.network)
    except ValueError as error:
        sys.exit(f"drive: {error}")
    for seed in options.seeds:
        route_m = long_route(seed, least_radius_m=options.least_radius)
        result, planner = drive(network, route_m, options.left, options.turned)
        metrics = result.metrics
        print(
            f"route {seed}: {metrics['status']:9s} {metrics['route_completion_percent']:5.1f} % "
            f"cross-track error {metrics['cross_track_rms_m']:.3f} m RMS, "
            f"{metrics['cross_track_max_m']:.3f} m at worst, {metrics['duration_s']:.0f} s, "
            f"{1e3 * np.median(planner.picture_s):.1f} ms a picture",
            flush=True,
        )


if __name__ == "__main__":
    main()
