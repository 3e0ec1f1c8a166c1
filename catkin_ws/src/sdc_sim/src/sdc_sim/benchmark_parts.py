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
from rosgraph_msgs.msg import Clock
from sdc_package.msg import CarlaVehicleControl, LocalPath, Waypoint

from sdc_package.waypoints import load_waypoints
from sdc_sim.messages import image_message, odometry_message
from sdc_sim.rehearsal import TICK_S, Thinking, load_preset, node_config
from sdc_sim.renderer import Renderer
from sdc_sim.road import Road

_TICKS = 1200


def parts_ms() -> dict:
    """Median milliseconds of each part over a minute of driving on the packaged route, one thread."""
    cv2.setNumThreads(1)
    route = load_waypoints(os.path.join(rospkg.RosPack().get_path("sdc_package"), "data", "waypoints.csv"))
    thinking = Thinking(route, node_config("simple_controller")["steering_method"])
    vehicle = load_preset("tesla_model3")
    vehicle.reset(*route[0].tolist(), math.atan2(*(route[1] - route[0])[::-1]))
    renderer = Renderer(Road(route))
    buffer = io.BytesIO()
    times = {name: [] for name in ("planner", "controller", "physics", "serialise", "render", "serialise the picture")}
    clock = time.perf_counter
    for tick in range(_TICKS):
        stamp = rospy.Time.from_sec((tick + 1) * TICK_S)
        state = vehicle.state
        marks = [clock()]
        rows = thinking.plan(state)
        marks.append(clock())
        command = thinking.command(rows, state)
        marks.append(clock())
        vehicle.step(command, TICK_S)
        marks.append(clock())
        for message in (Clock(stamp), odometry_message(state, stamp), LocalPath([Waypoint(*row) for row in rows]),
                        CarlaVehicleControl(throttle=command.throttle, steer=command.steer, brake=command.brake)):
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
