"""The topic of the vehicle's true motion."""

from __future__ import annotations

import rospy

# Where a simulator with `truth: false` publishes what it otherwise publishes as odometry.
GROUND_TRUTH = "/sim/ground_truth/odometry"


def true_odometry_topic(ego: str) -> str:
    """Return the topic with the true odometry of the vehicle.

    Args:
        ego: prefix of the topics of the vehicle, such as /carla/ego_vehicle
    """
    return ego + "/odometry" if rospy.get_param("/sim/truth", True) else GROUND_TRUTH
