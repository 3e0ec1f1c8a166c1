"""Benchmark of a scan of each lidar along the packaged route.

    python3 -m sdc_experiments.benchmark_lidar

A scan includes the points that a message contains, without noise. The times are those of the
processor on one core; the two lidars and a fixed amount of NumPy work alternate, so that other
programs on the machine slow all of them.
"""

from __future__ import annotations

import os
import time
from typing import Callable

import numpy as np
import rospkg

from sdc_common.geometry.route import Route
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.physics.vehicle_parameters import load_vehicle
from sdc_sim.road.road import Road
from sdc_sim.sensors.lidar import PlanarLidar, RoofLidar
from sdc_sim.sensors.model import Moment, SensorContext
from sdc_sim.sensors.settings import LidarSettings

_STEP_M = 0.5  # 10 m/s at 20 Hz
_SCANS = 1000
_REFERENCE = np.linspace(0.0, 1.0, 16_384)


def main() -> None:
    """Print the time of a scan of each lidar."""
    packages = rospkg.RosPack()
    route_m = load_waypoints(os.path.join(packages.get_path("sdc_common"), "data", "waypoints.csv"))
    preset = os.path.join(packages.get_path("sdc_sim"), "config", "vehicles", "tesla_model3.yaml")
    scenery, route = Road(route_m).scenery(), Route(route_m)
    context = SensorContext(0, 0, 0.05, load_vehicle(preset), None, lambda: scenery)
    planar = PlanarLidar(LidarSettings(period_s=0.05, range_m=30.0), context)
    rings = RoofLidar(LidarSettings(period_s=0.05), context)
    works: dict[str, Callable[[Moment], object]] = {
        "planar lidar, 1,080 beams": lambda moment: planar.read(moment, 0),
        "16 rings of 1,024 columns": lambda moment: rings.read(moment, 0),
        "reference: sine of 16,384 numbers": lambda _moment: np.sin(_REFERENCE),
    }
    times: dict[str, list[float]] = {name: [] for name in works}
    for number in range(_SCANS):
        s_m = (_STEP_M * number) % route.length_m
        x_m, y_m = route.line.point_at(s_m)
        moment = Moment(0.0, VehicleState(x_m=x_m, y_m=y_m, yaw_rad=route.line.heading_at(s_m)))
        for name, work in works.items():
            start_s = time.process_time()
            work(moment)
            times[name].append(time.process_time() - start_s)
    for name, seconds in times.items():
        low, middle, high = 1e3 * np.percentile(seconds, [5, 50, 95])
        print(f"{name:34} {middle:6.3f} ms (median; 5 to 95 %: {low:.3f} to {high:.3f} ms)")
    print("load of the machine: " + " ".join(f"{load:.1f}" for load in os.getloadavg()))


if __name__ == "__main__":
    main()
