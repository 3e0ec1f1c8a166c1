"""The start pose on the route, and the check of points and poses from RViz."""

import math

import numpy as np
import pytest
from geometry_msgs.msg import Point, Pose, Quaternion

from sdc_common.geometry.route import Route
from sdc_sim.ros.message_conversion import map_point, map_pose
from sdc_sim.scenario.configuration import start_pose


def test_pose_in_the_map_becomes_numbers():
    pose = Pose(Point(1.0, 2.0, 9.0), Quaternion(0, 0, math.sin(0.25), math.cos(0.25)))
    assert map_pose("map", pose) == pytest.approx((1.0, 2.0, 0.5))
    assert map_point("", Point(1.0, 2.0, 0.0)) == (1.0, 2.0)


@pytest.mark.parametrize(
    ("frame", "x", "y", "message"),
    [
        *(("ego_vehicle", 0.0, 0.0, "Fixed Frame"), ("map", math.nan, 0.0, "not finite")),
        *(("map", 0.0, -math.inf, "not finite"), ("map", 1e9, 0.0, "farther than")),
    ],
)
def test_invalid_point_is_refused(frame, x, y, message):
    with pytest.raises(ValueError, match=message):
        map_point(frame, Point(x, y, 0.0))


@pytest.mark.parametrize("q", [(0, 0, 0, 0), (0, 0, 0, math.nan), (0, 0, 5, 5)])
def test_invalid_orientation_is_refused(q):
    with pytest.raises(ValueError, match="quaternion"):
        map_pose("map", Pose(Point(), Quaternion(*q)))


ROUTE = Route(np.array([(0.0, 0.0), (10.0, 0.0), (10.0, 20.0)]))


@pytest.mark.parametrize(
    ("start", "pose"),
    [
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((4.0, 2.0, -0.5), (4.0, 2.0, -0.5)),
        ((15.0, 1.0, 0.25), (9.0, 5.0, math.pi / 2 + 0.25)),
        ((30.0, 0.0, 0.0), (10.0, 20.0, math.pi / 2)),
    ],
)
def test_start_is_along_the_route_and_to_its_left(start, pose):
    assert start_pose(ROUTE, *start) == pytest.approx(pose)


@pytest.mark.parametrize(
    ("start", "part"),
    [
        ((-1.0, 0.0, 0.0), "along_m"),
        ((31.0, 0.0, 0.0), "30.0 m"),
        ((math.nan, 0.0, 0.0), "along_m"),
    ],
)
def test_start_outside_the_route_is_refused(start, part):
    with pytest.raises(ValueError, match=part):
        start_pose(ROUTE, *start)
