#!/usr/bin/python3
"""Test of the show node: messages for RViz, late subscribers, invalid input."""

import math
import unittest

import genpy.dynamic
import rospy
import rostest
from nav_msgs.msg import Path as DisplayedPath
from sdc_msgs.msg import BaseWaypoint, Path
from sensor_msgs.msg import NavSatFix, NavSatStatus
from visualization_msgs.msg import Marker, MarkerArray

from sdc_common.geometry.geodesy import geodetic_from_map
from sdc_common.processes import wait_until
from sdc_testing import MessageListener, wait_for_subscriber

# The messages of another package, whose waypoints have one field more than those of sdc_msgs.
FIELDS = "MSG: other/Waypoint\nfloat32 x\nfloat32 y\nfloat32 yaw\nfloat32 v"
DEFINITION = "\n".join(["Waypoint[] waypoints", "=" * 80, FIELDS])
CLASSES = genpy.dynamic.generate_dynamic("other/LocalPath", DEFINITION)
LocalPath, OtherWaypoint = CLASSES["other/LocalPath"], CLASSES["other/Waypoint"]


def waypoint(x, y, v):
    return OtherWaypoint(x=x, y=y, yaw=0.5, v=v)


class ShowTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.mission = rospy.Publisher("/planner/mission_waypoints", Path, queue_size=10)
        cls.local_path = rospy.Publisher("/planner/local_waypoints", LocalPath, queue_size=10)
        wait_for_subscriber(cls.mission)
        wait_for_subscriber(cls.local_path)

    def show_path(self, listener, *rows):
        """Publish a local path until the node shows it: the node limits its rate."""
        before = len(listener.messages)

        def is_shown():
            self.local_path.publish(LocalPath([waypoint(*row) for row in rows]))
            return len(listener.messages) > before

        wait_until(is_shown, what="a local path")
        return listener.messages[-1]

    def test_mission_is_shown_as_route_and_road(self):
        self.mission.publish(Path([BaseWaypoint(x, 2.0) for x in range(50)]))
        for _ in range(2):  # the topics are latched for the second, late listener
            route = MessageListener("/show/route", DisplayedPath).wait_for(
                lambda path: len(path.poses) == 50
            )
            self.assertEqual(route.header.frame_id, "map")
            places = [(pose.pose.position.x, pose.pose.position.y) for pose in route.poses]
            self.assertEqual(places, [(x, 2.0) for x in range(50)])
            road = MessageListener("/show/road", MarkerArray).wait_for()
            self.assertEqual([marker.ns for marker in road.markers], ["grass", "asphalt", "lines"])
            for marker in road.markers:
                self.assertEqual((marker.header.frame_id, marker.action), ("map", Marker.ADD))
                self.assertGreater(len(marker.points), 5)

    def test_fixes_are_shown_as_dots_in_the_map(self):
        gnss = rospy.Publisher("/carla/ego_vehicle/gnss/front/gnss", NavSatFix, queue_size=10)
        wait_for_subscriber(gnss)
        dots = MessageListener("/show/gnss", Marker)
        dots.wait_for_publisher()
        gnss.publish(NavSatFix(status=NavSatStatus(status=NavSatStatus.STATUS_NO_FIX)))
        latitude, longitude = geodetic_from_map(12.0, -7.0)
        gnss.publish(NavSatFix(latitude=latitude, longitude=longitude))
        marker = dots.wait_for()
        self.assertEqual(marker.header.frame_id, "map")
        (point,) = marker.points
        self.assertLess(math.hypot(point.x - 12.0, point.y + 7.0), 1e-3)

    def test_local_path_is_coloured_by_speed(self):
        listener = MessageListener("/show/local_path", Marker)
        listener.wait_for_publisher()
        marker = self.show_path(listener, (0.0, 0.0, 10.0), (1.0, 0.0, 5.0), (2.0, 0.0, 0.0))
        self.assertEqual((marker.header.frame_id, marker.type), ("map", Marker.LINE_STRIP))
        self.assertEqual([point.x for point in marker.points], [0.0, 1.0, 2.0])
        self.assertGreater(marker.colors[0].g, marker.colors[0].r)
        self.assertGreater(marker.colors[2].r, marker.colors[2].g)
        self.assertEqual(self.show_path(listener).action, Marker.DELETE)

    def test_car_is_latched(self):
        markers = MessageListener("/show/car", MarkerArray).wait_for().markers
        self.assertEqual({marker.header.frame_id for marker in markers}, {"ego_vehicle"})
        self.assertTrue(all(marker.frame_locked for marker in markers))
        self.assertEqual(len({(marker.ns, marker.id) for marker in markers}), len(markers))
        ends = [(one.pose.position.x, 0.5 * one.scale.x) for one in markers]
        length_m = max(x + half for x, half in ends) - min(x - half for x, half in ends)
        self.assertAlmostEqual(length_m, 4.72, delta=0.05)


if __name__ == "__main__":
    rospy.init_node("show_test")
    rostest.rosrun("sdc_sim", "show_test", ShowTest)
