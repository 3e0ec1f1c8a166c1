"""Time each part of a tick alone, in one process: python3 -m sdc_experiments.benchmark_parts."""

from __future__ import annotations

import io
import math
import os
import time
from typing import Any

import cv2
import numpy as np
import rospkg
import rospy
from rosgraph_msgs.msg import Clock
from sdc_package.msg import CarlaVehicleControl, LocalPath, Waypoint

from sdc_common.routes.waypoint_file import load_waypoints
from sdc_experiments.car_stack import CarController, CarPlanner
from sdc_experiments.configuration import vehicle_preset
from sdc_sim.camera.renderer import Renderer
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.road.road import Road
from sdc_sim.ros.message_conversion import image_message, odometry_message
from sdc_sim.simulation.simulation import Observation

PARTS = ("planner", "controller", "physics", "serialize", "render", "serialize the picture")
_TICKS = 1200
TICK_S = 0.05


def parts_ms() -> dict[str, float]:
    """Return the median time of each part in a minute of driving, with one thread [ms]."""
    cv2.setNumThreads(1)
    data = os.path.join(rospkg.RosPack().get_path("sdc_common"), "data")
    route = load_waypoints(os.path.join(data, "waypoints.csv"))
    planner, controller = CarPlanner(route), CarController()
    vehicle = Vehicle(vehicle_preset("tesla_model3"))
    (x, y), (next_x, next_y) = route[:2].tolist()
    vehicle.reset(x, y, math.atan2(next_y - y, next_x - x))
    renderer = Renderer(Road(route))
    table = [_tick_s(tick, planner, controller, vehicle, renderer) for tick in range(_TICKS)]
    return dict(zip(PARTS, (1e3 * np.median(table, axis=0)).tolist()))


def _tick_s(
    tick: int, planner: CarPlanner, controller: CarController, vehicle: Vehicle, renderer: Renderer
) -> list[float]:
    """Drive one tick and return the time of each of PARTS [s]."""
    clock = time.perf_counter
    stamp = rospy.Time.from_sec((tick + 1) * TICK_S)
    state = vehicle.state
    observation = Observation((stamp.secs, stamp.nsecs), state, state)
    marks = [clock()]
    rows = planner(observation)
    marks.append(clock())
    command = controller(observation, rows)
    marks.append(clock())
    vehicle.step(command, TICK_S)
    marks.append(clock())
    for message in (
        Clock(stamp),
        odometry_message(state, stamp),
        LocalPath([Waypoint(*row) for row in rows]),
        CarlaVehicleControl(throttle=command.throttle, steer=command.steer, brake=command.brake),
    ):
        type(message)().deserialize(_serialized(message))
    marks.append(clock())
    picture = renderer.render(state.x_m, state.y_m, state.yaw_rad)
    marks.append(clock())
    image_message(picture, stamp).serialize(io.BytesIO())
    marks.append(clock())
    return [end - start for start, end in zip(marks, marks[1:])]


def _serialized(message: Any) -> bytes:
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def main() -> None:
    """Measure all parts and print them."""
    for part, milliseconds in parts_ms().items():
        print(f"{part:<22} {milliseconds:.3f} ms")


if __name__ == "__main__":
    main()
