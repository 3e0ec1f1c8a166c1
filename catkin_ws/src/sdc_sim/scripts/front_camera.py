#!/usr/bin/env python3
"""Front camera: paints and publishes the pictures of the observations that the sim sends."""

import os

import rospy

from sdc_common.ros.node import parameter, spin_with
from sdc_sim.ros.front_camera import FrontCamera
from sdc_sim.ros.picture_feed import connect


def main():
    # Each observation carries its stamp.
    rospy.init_node("front_camera", disable_rostime=True)
    connection, settings = connect(parameter("picture_feed"))
    settings = settings._replace(daylight=rospy.get_param("~daylight", settings.daylight))
    if not settings.every_frame:
        # In real time a picture may be dropped, but the control loop is not to be late.
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    spin_with(FrontCamera(connection, settings).loop)


if __name__ == "__main__":
    main()
