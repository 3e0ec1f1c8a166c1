"""Measure how exactly the steering methods follow fast random roads, and what a step costs.

python3 -m sdc_experiments.tracking [METHOD ...] [seeds:=1,2,3]

METHOD is a name of config/simple_controller.yaml, or nonlinear_mpc. It prints rows of a Markdown
table: the greatest RMS and worst true cross-track error of the drives, and the processor time of a
step at the 99th percentile.
"""

from __future__ import annotations

import sys
import time
from typing import Any, Mapping

import numpy as np

from sdc_experiments.closed_loop import drive_result
from sdc_experiments.configuration import node_parameters
from sdc_experiments.sweep.true_metrics import true_metrics
from sdc_package.steering.axles import Axles
from sdc_package.steering.loader import METHODS, load_steering
from sdc_package.steering.method import Steering
from sdc_sim.physics.vehicle import VehicleState

_NOISE = {"position_m": 0.05, "heading_rad": 0.0, "speed_mps": 0.0}
_WET = {"friction": 0.6, "odometry_noise": _NOISE}
# Name, planned speed [m/s], and parameters of config/sim.yaml. The town has tight bends.
CONDITIONS: tuple[tuple[str, str, float, Mapping[str, Any]], ...] = (
    ("dry, 20 m/s", "bends", 20.0, {}),
    ("wet, commands 0.1 s late", "bends", 20.0, {**_WET, "command_latency_s": 0.1}),
    ("wet, odometry 0.1 s late", "bends", 20.0, {**_WET, "sensor_latency_s": 0.1}),
    ("the town, dry", "town", 10.0, {}),
    ("the town, wet, commands 0.1 s late", "town", 10.0, {**_WET, "command_latency_s": 0.1}),
)


def fast_bends(seed: int) -> list[dict[str, float]]:
    """Return straights and bends of 135 to 400 m radius, for 20 m/s at 3 m/s^2."""
    random = np.random.default_rng(seed)
    elements = [{"straight_m": 40.0}]
    for _ in range(7):
        side = "left_deg" if random.uniform() < 0.5 else "right_deg"
        angle, radius_m = random.uniform(20.0, 60.0), random.uniform(135.0, 400.0)
        bend = {side: angle, "radius_m": radius_m, "transition_m": random.uniform(15.0, 30.0)}
        elements += [bend, {"straight_m": random.uniform(10.0, 60.0)}]
    return elements


def method_of(name: str) -> Steering:
    """Return a steering method; raise ValueError if it cannot be built."""
    config = node_parameters("simple_controller")
    axles = Axles(**config["axles"])
    if name == "nonlinear_mpc":
        from sdc_mpc.nonlinear import NonlinearMpc

        return NonlinearMpc(axles, **config["mpc"])
    return load_steering(name, config.get(name), axles)


def measure(
    name: str, road: str, speed_mps: float, sim_options: Mapping[str, Any], seed: int
) -> tuple[float, float, float]:
    """Return RMS and worst true cross-track error [m] of a drive, and p99 of a step [s]."""
    method = method_of(name)
    steps_s: list[float] = []
    states: list[VehicleState] = []
    wheel_angle = method.wheel_angle

    def timed(*arguments: Any) -> float:
        start = time.process_time()
        angle = wheel_angle(*arguments)
        steps_s.append(time.process_time() - start)
        return angle

    method.wheel_angle = timed  # type: ignore[assignment,method-assign]
    result = drive_result(
        route=fast_bends(seed) if road == "bends" else None,
        steering=method,
        seed=seed,
        sim_options=sim_options,
        planner_options={"planned_speed_mps": speed_mps},
        observe=lambda snapshot: states.append(snapshot.state),
    )
    found = true_metrics(result.rows, states)
    if result.metrics["status"] != "completed":
        return float("inf"), float("inf"), float(np.percentile(steps_s, 99))
    rms, worst = found["true_cross_track_rms_m"], found["true_cross_track_max_m"]
    return float(rms or 0.0), float(worst or 0.0), float(np.percentile(steps_s, 99))


def main() -> None:
    """Run the command."""
    names = [word for word in sys.argv[1:] if ":=" not in word] or [*METHODS]
    seeds = next((word[7:] for word in sys.argv[1:] if word.startswith("seeds:=")), "1,2,3")
    print("| road | method | RMS | worst | step, p99 |\n|---|---|---|---|---|")
    try:
        for title, road, speed_mps, options in CONDITIONS:
            for name in names:
                drives = (name, road, speed_mps, options)
                rows = [measure(*drives, int(seed)) for seed in seeds.split(",")]
                rms, worst, step_s = np.max(rows, axis=0)
                errors = f"{100 * rms:.1f} cm | {100 * worst:.1f} cm"
                print(f"| {title} | `{name}` | {errors} | {1e3 * step_s:.1f} ms |", flush=True)
    except ValueError as error:
        sys.exit(f"tracking: {error}")


if __name__ == "__main__":
    main()
