#!/usr/bin/env python3
"""Record: writes what the referee receives to a bag, for replay.py, and more for viewers."""

import contextlib
import os
import threading

import rosbag
import rospy

from sdc_common.ros.node import parameter, refuse
from sdc_sim.report.writer import companion

NS_PER_S = 1_000_000_000
PICTURE_NS = 200_000_000  # pictures are most of a bag; one every 0.2 s is enough to look at


class Record:
    def __init__(self):
        rospy.init_node("record")
        self.bag_path = companion(os.path.expanduser(parameter("report")), ".bag")
        try:
            os.makedirs(os.path.dirname(self.bag_path) or ".", exist_ok=True)
            self.bag = rosbag.Bag(self.bag_path, "w")
        except OSError as error:
            refuse(
                f"{error.filename}: {error.strerror}; the bag is written next to the report: "
                "name another folder with report:=FILE"
            )

        self.lock = threading.RLock()
        self.last_ns = self.next_picture_ns = 0
        rospy.on_shutdown(self.close)
        for topic in parameter("topics"):
            # AnyMsg keeps the bytes of a message. Without queue_size, none is dropped.
            rospy.Subscriber(
                topic, rospy.AnyMsg, self.on_message, callback_args=topic, tcp_nodelay=True
            )

    def on_message(self, message, topic):
        with self.lock:
            if self.bag is None:
                return
            # A bag is read in the order of its times. Different times keep the order of arrival.
            self.last_ns = max(rospy.get_rostime().to_nsec(), self.last_ns + 1)
            if topic.endswith("/compressed"):
                if self.last_ns < self.next_picture_ns:
                    return
                self.next_picture_ns = self.last_ns + PICTURE_NS
            names = ("type", "md5sum", "message_definition")
            header = {name: message._connection_header[name] for name in names}
            header["topic"] = topic
            time = rospy.Time(*divmod(self.last_ns, NS_PER_S))
            try:
                self.bag.write(topic, message, time, connection_header=header)
            except OSError as error:
                rospy.logerr(
                    "record: %s: %s; the rest of the drive is not recorded",
                    self.bag_path,
                    error.strerror,
                )
                self.close()

    def close(self):
        with self.lock:
            bag, self.bag = self.bag, None
            if bag is not None:
                with contextlib.suppress(OSError):
                    bag.close()

    def run(self):
        rospy.spin()


if __name__ == "__main__":
    Record().run()
