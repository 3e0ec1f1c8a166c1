#!/usr/bin/env python3
"""Mission planner: loads the route from a CSV file and publishes it once, latched, for whoever comes when."""
import rospy
from sdc_package.msg import BaseWaypoint, Path

from sdc_package.node import parameter, refuse
from sdc_package.waypoints import WaypointError, load_waypoints


class MissionPlanner:
    def __init__(self):
        rospy.init_node("mission_planner")
        waypoints_path = parameter("waypoints_path")

        try:
            self.waypoints = load_waypoints(waypoints_path)
        except WaypointError as error:
            refuse(error)

        self.publisher = rospy.Publisher("/planner/mission_waypoints", Path, queue_size=1, latch=True)

    def publish(self):
        path = Path(waypoints=[BaseWaypoint(x, y) for x, y in self.waypoints.tolist()])
        self.publisher.publish(path)
        rospy.loginfo("mission_planner: published a route of %d waypoints", len(path.waypoints))

    def run(self):
        self.publish()
        rospy.spin()


if __name__ == "__main__":
    MissionPlanner().run()
