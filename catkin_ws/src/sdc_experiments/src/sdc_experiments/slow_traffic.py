"""Drive among slow vehicles, and print what that costs: python3 -m sdc_experiments.slow_traffic.

`... slow_traffic [COUNT]` drives each type under `others` of street_scenarios.yaml with COUNT seeds
(10) in the town, and the same way alone: mean speed in shares of that without the others, and the
longest time within 30 m behind one who drives in the car's lane.
"""

from __future__ import annotations

import math
import sys
from collections import defaultdict

from sdc_experiments.closed_loop import drive
from sdc_sim.scenario.street_scenarios import of_map
from sdc_sim.simulation.snapshot import Snapshot
from sdc_sim.yaml_document import packaged_config

_NEAR_M, _BESIDE_M, _MOVING_MPS = 30.0, 2.0, 0.5


def seconds_behind(snapshots: list[Snapshot]) -> float:
    """Return the longest time in which the same one was close before the car [s]."""
    behind: dict[int, float] = defaultdict(float)
    longest_s, last_ns = 0.0, snapshots[0].stamp_ns
    for one in snapshots:
        car, step_s = one.state, 1e-9 * (one.stamp_ns - last_ns)
        c, s, last_ns, close = math.cos(car.yaw_rad), math.sin(car.yaw_rad), one.stamp_ns, set()
        for other in one.obstacles:
            x, y = other.x_m - car.x_m, other.y_m - car.y_m
            moves = other.speed_mps * math.cos(other.yaw_rad - car.yaw_rad) > _MOVING_MPS
            if moves and 0.0 < c * x + s * y < _NEAR_M and abs(c * y - s * x) < _BESIDE_M:
                close.add(other.id)
        behind = defaultdict(float, {number: behind[number] + step_s for number in close})
        longest_s = max(longest_s, *behind.values(), 0.0)
    return longest_s


def main() -> None:
    """Run the command line."""
    count = int(sys.argv[1]) if sys.argv[1:] else 10
    for name in packaged_config("street_scenarios")["others"]:
        shares, longest_s, faults, complete = [], 0.0, 0, 0
        for seed in range(1, count + 1):
            placed, options = of_map("town", name, seed), {"street_scenario": name}
            snapshots: list[Snapshot] = []
            slow = drive(map="town", seed=seed, sim_options=options, observe=snapshots.append)
            alone = drive(map="town", start=placed.start, goal=placed.goals)
            shares.append(slow["speed_mean_mps"] / alone["speed_mean_mps"])
            longest_s = max(longest_s, seconds_behind(snapshots))
            faults += slow["collisions_at_fault"]
            complete += slow["status"] == "completed"
        print(
            f"{name}: {complete} of {count} complete, {faults} collisions at fault, mean speed "
            f"{100.0 * sum(shares) / count:.1f} % of that alone (least {100.0 * min(shares):.1f} "
            f"%), at most {longest_s:.1f} s behind the same one"
        )


if __name__ == "__main__":
    main()
