#!/usr/bin/env python3
"""Generate a waypoint file from a list of straights and bends.

Usage: data/draw_route.py data/town.yaml data/waypoints.csv

data/town.yaml is an example that explains every key.
"""

from __future__ import annotations

import argparse
import os
import sys

import numpy as np
import yaml

# The script also runs without a built workspace.
sys.path.insert(
    0,
    os.path.join(
        os.path.dirname(os.path.realpath(__file__)), "..", "catkin_ws", "src", "sdc_sim", "src"
    ),
)
from sdc_sim.road.route_generator import RouteSpecError, csv_lines, generate_route  # noqa: E402


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("spec", help="YAML list of straights and bends")
    parser.add_argument("csv", help="output file: x,y,yaw-degrees in CARLA coordinates")
    arguments = parser.parse_args()
    try:
        with open(arguments.spec, encoding="utf-8") as file:
            rows = generate_route(yaml.safe_load(file))
    except (OSError, yaml.YAMLError, RouteSpecError) as error:
        print(f"{arguments.spec}: {error}", file=sys.stderr)
        return 1
    except (KeyError, TypeError) as error:
        print(
            f"{arguments.spec}: {error} is missing or not valid; see data/town.yaml for an example",
            file=sys.stderr,
        )
        return 1
    with open(arguments.csv, "w", encoding="utf-8") as file:
        file.writelines(csv_lines(rows))
    length = np.hypot(*np.diff(rows[:, :2], axis=0).T).sum()
    print(f"{arguments.csv}: {len(rows)} waypoints, {length:.1f} m")
    return 0


if __name__ == "__main__":
    sys.exit(main())
