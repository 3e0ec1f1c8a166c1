#!/usr/bin/env python3
"""Mission planner: loads the route from a CSV file and publishes it once, latched, for whoever comes when."""

import rospy

# TODO 1: the two messages of a mission: a point, and the path of all points
from sdc_package.msg import BaseWaypoint, Path
# --------------------------------------------------------------------------------

from sdc_common.ros.node import parameter, refuse
from sdc_common.ros.connection_watchdog import watch_connections
from sdc_common.routes.waypoint_file import WaypointError, load_waypoints


class MissionPlanner:
    def __init__(self):
        # TODO 2: register this program with ROS as the node "mission_planner"
        rospy.init_node("mission_planner")
        # ------------------------------------------------------------------------
        # TODO 3: a latched publisher, which repeats the mission to whoever asks for it later
        self.publisher = rospy.Publisher(
            "/planner/mission_waypoints", Path, queue_size=1, latch=True
        )
        # ------------------------------------------------------------------------
        # TODO 4: which file? The launch file says so in the parameter "waypoints_path"
        waypoints_path = parameter("waypoints_path")
        # ------------------------------------------------------------------------
        # TODO 5: load the waypoints; end with one clear line when the file is bad (until then: self.waypoints = [])
        try:
            self.waypoints = load_waypoints(waypoints_path)
        except WaypointError as error:
            refuse(error)
        # ------------------------------------------------------------------------

    def publish(self):
        # TODO 8: one BaseWaypoint for each row x, y (until then: waypoints = [])
        waypoints = [BaseWaypoint(x, y) for x, y in self.waypoints.tolist()]
        # ------------------------------------------------------------------------
        # TODO 9: put them into a Path, publish it and say so
        self.publisher.publish(Path(waypoints))
        rospy.loginfo("mission_planner: published a route of %d waypoints", len(waypoints))
        # ------------------------------------------------------------------------

    def run(self):
        watch_connections()
        # TODO 6: publish what was loaded (until then: pass)
        self.publish()
        # ------------------------------------------------------------------------
        # TODO 7: stay, until ROS ends this node: who ends takes what is latched along
        rospy.spin()
        # ------------------------------------------------------------------------


if __name__ == "__main__":
    MissionPlanner().run()
