"""Record drives of the car's planner and controller, the expert, as samples for the network.

python3 -m sdc_perception.imitation.record FILE [--routes N] drives random routes.
python3 -m sdc_perception.imitation.record FILE --bag BAG reads pictures and odometry of a bag.
"""

from __future__ import annotations

import argparse
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat

import cv2
import numpy as np

from sdc_perception.imitation.bag import bag_samples
from sdc_perception.imitation.samples import Samples
from sdc_perception.imitation_samples import DrivenLine, road_view
from sdc_perception.study.drives import drive_nodes
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.random_routes import long_route
from sdc_sim.road.road import Road

ROUTES = 8
# Seeds of the recorded routes; the drives of the network use others.
FIRST_SEED = 2000
PICTURES_PER_S = 5
_TICKS_PER_PICTURE = 20 // PICTURES_PER_S
# A car at rest needs no steering, and a network that learns to stand never starts.
LEAST_SPEED_MPS = 2.0
# Limits of the distance and the angle to the line of the additional pictures.
LARGEST_OFFSET_M = 1.0
LARGEST_TURN_RAD = 0.2


def expert_line(route_m: np.ndarray) -> DrivenLine:
    """Return the line that the car drives along a route (N, 2)."""
    trace = drive_nodes(route_m=route_m, camera="false").trace
    poses = np.column_stack([trace[name] for name in ("x_m", "y_m", "yaw_rad")])
    return DrivenLine(trace["time_s"], poses, trace["speed_mps"])


def record_route(seed: int, least_radius_m: float = 8.0, length_m: float = 1000.0) -> Samples:
    """Drive a random route; return pictures on the line, and as many off the line."""
    cv2.setNumThreads(1)
    random = np.random.default_rng([seed, 1])
    route_m = long_route(seed, length_m, least_radius_m)
    line, renderer = expert_line(route_m), Renderer(Road(route_m))
    views, answers, off_line, picture = [], [], [], None
    for i in range(0, len(line.poses), _TICKS_PER_PICTURE):
        if line.speeds_mps[i] < LEAST_SPEED_MPS or not line.has_answer(i):
            continue
        left_m = random.uniform(-LARGEST_OFFSET_M, LARGEST_OFFSET_M)
        turned_rad = random.uniform(-LARGEST_TURN_RAD, LARGEST_TURN_RAD)
        for where in ((0.0, 0.0), (left_m, turned_rad)):
            picture = renderer.render(*line.displaced(i, *where), out=picture)
            views.append(road_view(picture))
            answers.append(line.answer(i, *where))
            off_line.append(where != (0.0, 0.0))
    return Samples(np.array(views), np.array(answers), np.array(off_line))


def record(routes: int = ROUTES, least_radius_m: float = 8.0) -> Samples:
    """Return the samples of random routes, recorded by two processes."""
    seeds = range(FIRST_SEED, FIRST_SEED + routes)
    with ProcessPoolExecutor(2) as pool:
        parts = []
        for seed, part in zip(seeds, pool.map(record_route, seeds, repeat(least_radius_m))):
            print(f"route {seed}: {len(part)} pictures", flush=True)
            parts.append(part)
    return Samples.joined(parts)


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="record drives for the steering network")
    parser.add_argument("file", help="file to write")
    parser.add_argument("--routes", type=int, default=ROUTES, help="number of random routes")
    parser.add_argument("--least-radius", type=float, default=8.0, help="of the bends [m]")
    parser.add_argument("--bag", help="a bag with pictures and odometry, in place of routes")
    options = parser.parse_args()
    started_s = time.monotonic()
    try:
        samples = (
            bag_samples(options.bag, LEAST_SPEED_MPS, PICTURES_PER_S)
            if options.bag
            else record(options.routes, options.least_radius)
        )
        samples.save(options.file)
    except (OSError, ValueError) as error:
        sys.exit(f"record: {error}")
    duration_s = time.monotonic() - started_s
    print(f"{options.file}: {len(samples)} pictures in {duration_s:.0f} s")


if __name__ == "__main__":
    main()
