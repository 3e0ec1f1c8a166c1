"""Messages have the definitions of the originals, and odometry that of the state."""

import importlib
import io
import math
import pathlib
from types import SimpleNamespace

import genpy.dynamic
import numpy as np
import pytest
import rospy
import yaml
from nav_msgs.msg import Odometry
from scipy.spatial.transform import Rotation
from sdc_msgs.msg import BaseWaypoint, LocalPath, Path, Waypoint
from std_msgs.msg import Header

from sdc_common.ros.odometry import pose_and_speed, vehicle_transform
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.ros.message_conversion import odometry_message, scan_message
from sdc_sim.ros.waypoint_messages import waypoint_rows
from sdc_sim.simulation.snapshot import Snapshot

TABLE = pathlib.Path(__file__).parent / "data" / "message_md5_sums.yaml"
SUMS = yaml.safe_load(TABLE.read_text())


@pytest.mark.parametrize(("package", "name", "md5"), SUMS)
def test_messages_have_the_md5_sums_of_the_originals(package, name, md5):
    kind = "msg" if name.startswith(("Carla", "Ackermann")) else "srv"
    assert getattr(importlib.import_module(f"{package}.{kind}"), name)._md5sum == md5


def test_messages_have_the_fields_of_the_contract():
    assert (BaseWaypoint.__slots__, BaseWaypoint._slot_types) == (["x", "y"], ["float32"] * 2)
    assert (Waypoint.__slots__, Waypoint._slot_types) == (["x", "y", "v"], ["float32"] * 3)
    assert (Path.__slots__, LocalPath.__slots__) == (["waypoints"], ["waypoints"])


def test_odometry_message_returns_the_state():
    state = VehicleState(
        x_m=1.0, y_m=-2.0, yaw_rad=2.5, speed_mps=3.0, lateral_speed_mps=4.0, yaw_rate_radps=0.5
    )
    message = odometry_message(state, rospy.Time(7))
    x, y, yaw, speed = pose_and_speed(message)
    assert (x, y, speed) == (1.0, -2.0, 5.0)
    assert math.isclose(yaw, 2.5)
    assert (message.twist.twist.linear.x, message.twist.twist.linear.y) == (3.0, 4.0)
    assert message.twist.twist.angular.z == 0.5
    transform = vehicle_transform(message)
    assert (transform.header.frame_id, transform.child_frame_id) == ("map", "ego_vehicle")
    assert transform.transform.rotation == message.pose.pose.orientation
    assert isinstance(message, Odometry)


def test_scan_has_the_range_of_each_beam_that_hit():
    # Half a degree to the right, straight ahead, and the last beam at the left.
    angles, ranges = np.radians([-0.5, 0.0, 134.75]), np.array([5.0, 2.0, 29.0])
    points = np.stack([ranges * np.cos(angles), ranges * np.sin(angles), 0.0 * ranges, ranges], 1)
    settings = SimpleNamespace(period_s=0.1, range_m=30.0)
    scan = scan_message(points.astype(np.float32), settings, Header(frame_id="front"))
    assert (scan.header.frame_id, scan.range_max, len(scan.ranges)) == ("front", 30.0, 1080)
    assert math.degrees(scan.angle_min) == pytest.approx(-135.0)
    assert math.degrees(scan.angle_max) == pytest.approx(134.75)
    assert math.degrees(scan.angle_increment) == pytest.approx(0.25)
    hits = np.flatnonzero(np.isfinite(scan.ranges))
    assert hits.tolist() == [538, 540, 1079]
    np.testing.assert_allclose(np.array(scan.ranges)[hits], ranges, rtol=1e-6)
    np.testing.assert_allclose(np.array(scan.intensities)[hits], ranges, rtol=1e-6)
    np.testing.assert_allclose(scan.angle_min + hits * scan.angle_increment, angles, atol=1e-6)


@pytest.mark.parametrize("yaw_rad", [0.0, 2.5, -1.0])
def test_pose_on_a_slope_has_height_and_pitch_and_the_heading_of_the_observation(yaw_rad):
    """REP 103: a positive pitch turns x, forward, towards -z, down."""
    pitch_rad = math.atan(0.1)
    state = VehicleState(yaw_rad=yaw_rad)
    message = odometry_message(state, rospy.Time(7), "ego_vehicle", 3.0, pitch_rad)
    q = message.pose.pose.orientation
    forward = Rotation.from_quat([q.x, q.y, q.z, q.w]).apply((1.0, 0.0, 0.0))
    level = math.cos(pitch_rad)
    down = -math.sin(pitch_rad)
    assert forward == pytest.approx((level * math.cos(yaw_rad), level * math.sin(yaw_rad), down))
    assert vehicle_transform(message).transform.translation.z == 3.0
    snapshot = Snapshot(1, state, state, z_m=3.0, pitch_rad=pitch_rad)
    assert snapshot.observation().yaw_rad == pose_and_speed(message)[2]
    assert snapshot.observation().z_m == message.pose.pose.position.z


POINTS = [{"x": 1.0, "y": 2.0, "v": 3.0}, {"x": 4.0, "y": 5.0, "v": 6.0}]


def received(points, fields, list_name="waypoints"):
    """Return the AnyMsg of a path whose waypoints have these fields."""
    head = [f"Waypoint[] {list_name}", "=" * 80, "MSG: other/Waypoint"]
    definition = "\n".join([*head, *(f"float32 {name}" for name in fields)])
    classes = genpy.dynamic.generate_dynamic("other/LocalPath", definition)
    waypoints = [classes["other/Waypoint"](**point) for point in points]
    buffer = io.BytesIO()
    classes["other/LocalPath"](waypoints).serialize(buffer)
    message = rospy.AnyMsg()
    message._buff = buffer.getvalue()
    message._connection_header = {"type": "other/LocalPath", "message_definition": definition}
    return message


@pytest.mark.parametrize(
    "fields", [("x", "y", "v"), ("x", "y", "yaw", "v"), ("v", "lane", "y", "x")]
)
def test_known_fields_are_read_whatever_the_others_are(fields):
    message = received(POINTS, fields)
    assert waypoint_rows(message, "x", "y", "v") == [(1.0, 2.0, 3.0), (4.0, 5.0, 6.0)]
    assert waypoint_rows(message, "x", "y") == [(1.0, 2.0), (4.0, 5.0)]


def test_definition_without_the_fields_is_refused_with_its_name():
    with pytest.raises(ValueError, match="other/LocalPath needs a list 'waypoints' with .* v;"):
        waypoint_rows(received([{"x": 1.0, "y": 2.0}], ("x", "y")), "x", "y", "v")
    with pytest.raises(ValueError, match="other/LocalPath needs a list 'waypoints'"):
        waypoint_rows(received(POINTS, ("x", "y", "v"), "points"), "x", "y", "v")


def test_bytes_that_do_not_fit_the_definition_are_refused():
    message = received(POINTS, ("x", "y", "v"))
    message._buff = message._buff[:-3]
    with pytest.raises(ValueError, match="cannot be read"):
        waypoint_rows(message, "x", "y", "v")
    message._connection_header = {"type": "other/LocalPath", "message_definition": "Nothing[] x"}
    with pytest.raises(ValueError, match="cannot be read"):
        waypoint_rows(message, "x", "y", "v")
