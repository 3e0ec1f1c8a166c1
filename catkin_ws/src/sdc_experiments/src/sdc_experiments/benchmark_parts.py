"""Times the parts of a tick alone, in one process: python3 -m sdc_experiments.benchmark_parts"""

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

from sdc_common.routes.waypoint_file import load_waypoints
from sdc_experiments.offline_drive import TICK_S, OfflineStack, load_preset, node_config
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.road import Road
from sdc_sim.ros.message_conversion import image_message, odometry_message

_TICKS = 1200


def parts_ms() -> dict:
    """Median milliseconds of each part over a minute of driving on the packaged route, one thread."""
    cv2.setNumThreads(1)
    route = load_waypoints(
        os.path.join(rospkg.RosPack().get_path("sdc_common"), "data", "waypoints.csv")
    )
    thinking = OfflineStack(route, node_config("simple_controller")["steering_method"])
    vehicle = load_preset("tesla_model3")
    vehicle.reset(*route[0].tolist(), math.atan2(*(route[1] - route[0])[::-1]))
    renderer = Renderer(Road(route))
    buffer = io.BytesIO()
    times = {
        name: []
        for name in (
            "planner",
            "controller",
            "physics",
            "serialise",
            "render",
            "serialise the picture",
        )
    }
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
        for message in (
            Clock(stamp),
            odometry_message(state, stamp),
            LocalPath([Waypoint(*row) for row in rows]),
            CarlaVehicleControl(
                throttle=command.throttle, steer=command.steer, brake=command.brake
            ),
        ):
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
