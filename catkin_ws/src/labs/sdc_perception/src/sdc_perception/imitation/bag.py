"""Samples of a recorded bag: the way in which the drives of a real car arrive."""

from __future__ import annotations

import math

import numpy as np
import rosbag

from sdc_common.ros.odometry import pose_and_speed
from sdc_common.ros.pictures import pixels_of
from sdc_perception.imitation.samples import Samples
from sdc_perception.imitation_samples import DrivenLine, road_view

ODOMETRY = "/carla/ego_vehicle/odometry"
PICTURES = "/carla/ego_vehicle/camera/rgb/front/image_color"


def bag_samples(path: str, least_speed_mps: float, pictures_per_s: float) -> Samples:
    """Return the samples of a bag with odometry and pictures. The car is on its line in all.

    Pictures at a lower speed, and those beyond the rate, are left out.

    Raises:
        ValueError: the bag is missing, damaged, or lacks the topics; the message is one line
    """
    times, rows, views, view_times = [], [], [], []
    next_s = -math.inf
    try:
        with rosbag.Bag(path) as bag:
            for topic, message, _ in bag.read_messages([ODOMETRY, PICTURES]):
                time_s = message.header.stamp.to_sec()
                if topic == ODOMETRY:
                    times.append(time_s)
                    rows.append(pose_and_speed(message))
                elif time_s >= next_s:
                    next_s = time_s + 0.99 / pictures_per_s
                    views.append(road_view(pixels_of(message, "bgra8")))
                    view_times.append(time_s)
    except (OSError, ValueError, rosbag.ROSBagException) as error:
        raise ValueError(f"{path}: cannot be read: {error}") from error
    for topic, found in ((ODOMETRY, rows), (PICTURES, views)):
        if not found:
            raise ValueError(f"{path}: has no message of {topic}; record it with rosbag record")
    order = np.argsort(times, kind="stable")
    table, times_s = np.array(rows)[order], np.array(times)[order]
    line = DrivenLine(times_s, table[:, :3], table[:, 3])
    places = np.searchsorted(times_s, np.array(view_times) - 1e-3)
    kept = [
        k
        for k, i in enumerate(places.tolist())
        if i < len(times_s) and line.speeds_mps[i] >= least_speed_mps and line.has_answer(i)
    ]
    if not kept:
        raise ValueError(f"{path}: has no picture of a car that drives {least_speed_mps} m/s")
    answers = np.array([line.answer(int(places[k])) for k in kept])
    return Samples(np.array(views)[kept], answers, np.zeros(len(kept), bool))
