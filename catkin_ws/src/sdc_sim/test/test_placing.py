"""What is pointed at in RViz is checked before the car or an obstacle is put there."""
from __future__ import annotations

import math

import pytest
from geometry_msgs.msg import Point, Pose, Quaternion

from sdc_sim.placing import PlaceError, checked_point, checked_pose


def test_a_pose_becomes_numbers():
    pose = Pose(Point(1.0, 2.0, 9.0), Quaternion(0, 0, math.sin(0.25), math.cos(0.25)))
    assert checked_pose("map", pose) == pytest.approx((1.0, 2.0, 0.5))
    assert checked_point("", Point(1.0, 2.0, 0.0)) == (1.0, 2.0)


@pytest.mark.parametrize(("frame", "x", "y", "message"), [
    ("ego_vehicle", 0.0, 0.0, "Fixed Frame"), ("map", math.nan, 0.0, "not finite"), ("map", 0.0, -math.inf, "not finite"),
    ("map", 1e9, 0.0, "farther than")])
def test_bad_points_are_refused(frame, x, y, message):
    with pytest.raises(PlaceError, match=message):
        checked_point(frame, Point(x, y, 0.0))


@pytest.mark.parametrize("q", [(0, 0, 0, 0), (0, 0, 0, math.nan), (0, 0, 5, 5)])
def test_bad_orientations_are_refused(q):
    with pytest.raises(PlaceError, match="quaternion"):
        checked_pose("map", Pose(Point(), Quaternion(*q)))
