"""Times the parts of a tick alone, in one process: python3 -m sdc_sim.benchmark_parts"""
from __future__ import annotations

import io
import math
import os
import time

import cv2
import numpy as np
import rospkg
import rospy
import yaml
from rosgraph_msgs.msg import Clock
from sdc_package.msg import CarlaVehicleControl, Waypoint
from sdc_package.msg import LocalPath as LocalPathMessage

from sdc_package.axles import Axles
from sdc_package.car import PedalMap, SteeringMap
from sdc_package.local_path import LocalPath
from sdc_package.obstacles import Caution
from sdc_package.pid import PidGains
from sdc_package.planning import LocalPlanner, SpeedLimits
from sdc_package.speed import SpeedControl, SpeedControlLimits
from sdc_package.steering import load_steering
from sdc_package.waypoints import load_waypoints
from sdc_sim.camera import CameraModel
from sdc_sim.messages import image_message, odometry_message
from sdc_sim.renderer import Renderer
from sdc_sim.road import Road
from sdc_sim.vehicle import Vehicle, VehicleCommand, load_vehicle

_TICK_S = 0.05
_TICKS = 1200


def parts_ms() -> dict:
    """Median milliseconds of each part over a minute of driving on the packaged route, one thread."""
    cv2.setNumThreads(1)
    packages = rospkg.RosPack()
    ours, theirs = packages.get_path("sdc_sim"), packages.get_path("sdc_package")
    with open(os.path.join(theirs, "config", "simple_controller.yaml"), encoding="utf-8") as file:
        config = yaml.safe_load(file)
    route = load_waypoints(os.path.join(theirs, "data", "waypoints.csv"))
    planner = LocalPlanner(route, SpeedLimits(10.0, 3.0, 1.8, 2.5), lookahead_m=25.0, join_within_m=20.0,
                        caution=Caution(side_m=0.4, gap_m=5.0, car_front_m=2.35, car_width_m=2.0))
    path = LocalPath()
    method = config["steering_method"]
    steering = load_steering(method, config[method], Axles(**config["axles"]))
    speed_control = SpeedControl(PidGains(**config["pid"]), SpeedControlLimits(**config["limits"]))
    steering_map, pedal_map = SteeringMap(**config["steering"]), PedalMap(**config["pedals"])
    vehicle = Vehicle(load_vehicle(os.path.join(ours, "config", "vehicles", "tesla_model3.yaml")))
    vehicle.reset(*route[0].tolist(), math.atan2(*(route[1] - route[0])[::-1]))
    renderer = Renderer(Road(route), CameraModel())
    buffer = io.BytesIO()
    times = {"planner": [], "controller": [], "physics": [], "serialise": [], "render": [], "serialise the picture": []}
    clock = time.perf_counter
    for tick in range(_TICKS):
        stamp = rospy.Time.from_sec((tick + 1) * _TICK_S)
        state = vehicle.state
        marks = [clock()]
        rows = planner.plan(state.x_m, state.y_m, state.yaw_rad).tolist()
        marks.append(clock())
        path.update(rows)
        target = path.nearest(state.x_m, state.y_m, speed_control.preview_m(state.speed_mps))
        wheel = steering.wheel_angle(path, state.x_m, state.y_m, state.yaw_rad, state.speed_mps, state.yaw_rate_radps)
        throttle, brake = pedal_map.pedals(
            speed_control.acceleration(target.speed_mps, target.acceleration_mps2, state.speed_mps, _TICK_S))
        steer, _ = steering_map.command(wheel, state.speed_mps)
        marks.append(clock())
        vehicle.step(VehicleCommand(throttle, steer, brake), _TICK_S)
        marks.append(clock())
        for message in (Clock(stamp), odometry_message(state, stamp), LocalPathMessage([Waypoint(*row) for row in rows]),
                        CarlaVehicleControl(throttle=throttle, steer=steer, brake=brake)):
            message.serialize(buffer)
            type(message)().deserialize(buffer.getvalue())
            buffer.seek(0)
            buffer.truncate()
        marks.append(clock())
        picture = renderer.render(state.x_m, state.y_m, state.yaw_rad)
        marks.append(clock())
        image_message(picture, stamp).serialize(buffer)
        marks.append(clock())
        buffer.seek(0)
        buffer.truncate()
        for values, start, end in zip(times.values(), marks, marks[1:]):
            values.append(end - start)
    return {name: 1e3 * float(np.median(values)) for name, values in times.items()}


if __name__ == "__main__":
    for part, milliseconds in parts_ms().items():
        print(f"{part:<22} {milliseconds:.3f} ms")
