#!/usr/bin/env python3
"""Mission planner: loads the route from a CSV file and publishes it once, latched, for whoever comes when."""
import rospy
# TODO 1: the two messages of a mission: a point, and the path of all points
# --------------------------------------------------------------------------------

from sdc_package.node import parameter, refuse
from sdc_package.surroundings import watch_surroundings
from sdc_package.waypoints import WaypointError, load_waypoints


class MissionPlanner:
    def __init__(self):
        # TODO 2: register this program with ROS as the node "mission_planner"
        # ------------------------------------------------------------------------
        # TODO 3: a latched publisher, which repeats the mission to whoever asks for it later
        # ------------------------------------------------------------------------
        # TODO 4: which file? The launch file says so in the parameter "waypoints_path"
        # ------------------------------------------------------------------------
        # TODO 5: load the waypoints; end with one clear line when the file is bad (until then: self.waypoints = [])
        self.waypoints = []
        # ------------------------------------------------------------------------

    def publish(self):
        # TODO 8: one BaseWaypoint for each row x, y (until then: waypoints = [])
        waypoints = []
        # ------------------------------------------------------------------------
        # TODO 9: put them into a Path, publish it and say so
        # ------------------------------------------------------------------------

    def run(self):
        watch_surroundings()
        # TODO 6: publish what was loaded (until then: pass)
        pass
        # ------------------------------------------------------------------------
        # TODO 7: stay, until ROS ends this node: who ends takes what is latched along
        # ------------------------------------------------------------------------


if __name__ == "__main__":
    MissionPlanner().run()
