"""Let a network drive random routes that it was not trained on, with the nodes in lockstep.

python3 -m sdc_perception.imitation.drive NETWORK [SEED ...] prints how well.
"""

from __future__ import annotations

import argparse
import os
import sys

import numpy as np
import yaml

from sdc_perception.imitation_network import SteeringNetwork
from sdc_perception.study.drives import NodesDrive, drive_nodes
from sdc_sim.road.random_routes import long_route

# Route 1 crosses itself: a picture does not show which way to go.
SEEDS = (2, 3, 4, 5, 6)


def drive(
    network: str, route_m: np.ndarray, left_m: float = 0.0, turned_rad: float = 0.0
) -> NodesDrive:
    """Drive along a route that only the referee knows.

    The start is `left_m` to its left, and `turned_rad` to the left of its heading.
    """
    return drive_nodes(
        route_m=route_m,
        sim_options={"start": {"left_m": left_m, "turned_rad": turned_rad}},
        perception="imitation",
        perception_options=yaml.safe_dump({"network": os.path.abspath(network)}).strip(),
        camera="true",
    )


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="let a steering network drive random routes")
    parser.add_argument("network", help="file of sdc_perception.imitation.train")
    parser.add_argument("seeds", nargs="*", type=int, default=SEEDS, help="seeds of the routes")
    parser.add_argument("--least-radius", type=float, default=8.0, help="of the bends [m]")
    options = parser.parse_args()
    try:
        SteeringNetwork.load(options.network)
    except ValueError as error:
        sys.exit(f"drive: {error}")
    for seed in options.seeds:
        route_m = long_route(seed, least_radius_m=options.least_radius)
        metrics = drive(options.network, route_m).metrics
        print(
            f"route {seed}: {metrics['status']:9s} {metrics['route_completion_percent']:5.1f} % "
            f"cross-track error {metrics['cross_track_rms_m']:.3f} m RMS, "
            f"{metrics['cross_track_max_m']:.3f} m at worst, {metrics['duration_s']:.0f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
