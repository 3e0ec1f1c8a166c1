#!/usr/bin/env python3
"""Mission planner: load the route from a CSV file and publish it, latched."""

import rospy
from sdc_common.ros.connection_watchdog import watch_connections
from sdc_common.ros.node import parameter, refuse
from sdc_common.ros.supervisor import supervise
from sdc_common.routes.waypoint_file import WaypointError, load_waypoints

# TODO 1: the two messages of a mission: a point, and the path of all points
# --------------------------------------------------------------------------------


class MissionPlanner:
    def __init__(self):
        # TODO 2: register this program with ROS as the node "mission_planner"
        # ------------------------------------------------------------------------
        # TODO 3: a latched publisher of the mission: nodes that start later receive it, too
        # ------------------------------------------------------------------------
        # TODO 4: the file name, which the launch file sets as the parameter "waypoints_path"
        # ------------------------------------------------------------------------
        # TODO 5: load the file; exit with one line if it is bad (until then: self.waypoints = [])
        self.waypoints = []
        # ------------------------------------------------------------------------

    def run(self):
        watch_connections()
        # TODO 6: one BaseWaypoint for each row x, y (until then: waypoints = [])
        waypoints = []
        # ------------------------------------------------------------------------
        # TODO 7: publish them as a Path, and log how many there are
        # ------------------------------------------------------------------------
        # TODO 8: keep running: when a node exits, its latched message is lost
        # ------------------------------------------------------------------------


if __name__ == "__main__":
    supervise()
    MissionPlanner().run()
