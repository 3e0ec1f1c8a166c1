"""Path messages are read by the definition of their publisher."""

import io

import genpy.dynamic
import pytest
import rospy
from sdc_msgs.msg import LocalPath, Waypoint

from sdc_sim.ros.waypoint_messages import waypoint_rows

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


def test_message_of_a_known_class_is_read():
    path = LocalPath([Waypoint(1.0, 2.0, 3.0)])
    assert waypoint_rows(path, "x", "y", "v") == [(1.0, 2.0, 3.0)]


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
