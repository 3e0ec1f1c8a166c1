#!/usr/bin/env python3
"""Mission planner: load the route from a CSV file and publish it, latched."""

import rospy
from sdc_common.ros.node import parameter, refuse, watch_connections
from sdc_common.routes.waypoint_file import WaypointError, load_waypoints

# TODO 1 (given): the two messages of a mission: a point, and the path of all points
from sdc_package.msg import BaseWaypoint, Path
# --------------------------------------------------------------------------------


class MissionPlanner:
    def __init__(self):
        # TODO 2: register this program with ROS as the node "mission_planner"
        rospy.init_node("mission_planner")
        # ------------------------------------------------------------------------
        # TODO 3 (given): a latched publisher of the mission: nodes that start later receive it, too
        topic = "/planner/mission_waypoints"
        self.publisher = rospy.Publisher(topic, Path, queue_size=1, latch=True)
        # ------------------------------------------------------------------------
        # TODO 4: the file name, which the launch file sets as the parameter "waypoints_path"
        waypoints_path = parameter("waypoints_path")
        # ------------------------------------------------------------------------
        # TODO 5: load the file; exit with one line if it is bad (until then: self.waypoints = [])
        try:
            self.waypoints = load_waypoints(waypoints_path)
        except WaypointError as error:
            refuse(error)
        # ------------------------------------------------------------------------

    def run(self):
        watch_connections()
        # TODO 6: one BaseWaypoint for each row x, y (until then: waypoints = [])
        waypoints = [BaseWaypoint(x, y) for x, y in self.waypoints.tolist()]
        # ------------------------------------------------------------------------
        # TODO 7: publish them as a Path, and log how many there are
        self.publisher.publish(Path(waypoints))
        rospy.loginfo("mission_planner: published a route of %d waypoints", len(waypoints))
        # ------------------------------------------------------------------------
        # TODO 8: keep running: when a node exits, its latched message is lost
        rospy.spin()
        # ------------------------------------------------------------------------


if __name__ == "__main__":
    MissionPlanner().run()
