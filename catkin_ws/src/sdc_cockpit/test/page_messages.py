"""Messages to the page and from the graph, as the tests of the cockpit send and read them."""

import io
import struct

import rospy

PICTURE_HEADER = struct.Struct("<BxxxIdd")


def read_picture(message):
    """Return kind, number, stamp [s], wall time [s] and file of a picture for the page."""
    return *PICTURE_HEADER.unpack_from(message), message[PICTURE_HEADER.size :]


def receive(view, topic, message, stamp_s=None):
    """Have a feed of a view receive a message as a subscriber of any type does."""
    if stamp_s is not None and hasattr(message, "header"):
        message.header.stamp = rospy.Time.from_sec(stamp_s)
    buffer = io.BytesIO()
    message.serialize(buffer)
    received = rospy.AnyMsg()
    received._buff = buffer.getvalue()
    received._connection_header = {"md5sum": message._md5sum, "type": message._type}
    next(feed for feed in view.feeds if feed.topic == topic).receive(received)
