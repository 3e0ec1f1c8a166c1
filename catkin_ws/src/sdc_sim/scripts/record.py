#!/usr/bin/env python3
"""Record: keeps what the referee hears in a bag, message by message and without loss, so that the drive can be scored again."""

import contextlib
import os
import threading
from types import SimpleNamespace

import rosbag
import rospy

from sdc_common.ros.node import parameter, refuse
from sdc_sim.report.writer import companion


class Record:
    def __init__(self):
        rospy.init_node("record")
        self.bag_path = companion(os.path.expanduser(parameter("report")), ".bag")
        try:
            os.makedirs(os.path.dirname(self.bag_path) or ".", exist_ok=True)
            self.bag = rosbag.Bag(self.bag_path, "w")
        except OSError as error:
            refuse(
                f"{error.filename}: {error.strerror}; the bag stands beside the report: name another folder with report:=FILE"
            )

        self.lock = threading.Lock()
        self.last_ns = 0
        rospy.on_shutdown(self.close)
        for topic in parameter("topics"):
            # Not one is left out, and none is understood: bytes go from the topic into the bag.
            rospy.Subscriber(
                topic, rospy.AnyMsg, self.on_message, callback_args=topic, tcp_nodelay=True
            )

    def on_message(self, message, topic):
        with self.lock:
            if self.bag is None:
                return
            # A bag is read in the order of its times: no two are equal, so that it is the order of hearing.
            self.last_ns = max(rospy.get_rostime().to_nsec(), self.last_ns + 1)
            time = rospy.Time(*divmod(self.last_ns, 1_000_000_000))
            header = {
                "topic": topic,
                **{
                    name: message._connection_header[name]
                    for name in ("type", "md5sum", "message_definition")
                },
            }
            raw = (
                header["type"],
                message._buff,
                header["md5sum"],
                SimpleNamespace(_md5sum=header["md5sum"]),
            )
            try:
                self.bag.write(topic, raw, time, raw=True, connection_header=header)
            except OSError as error:
                rospy.logerr(
                    "record: %s: %s; the rest of the drive is not recorded",
                    self.bag_path,
                    error.strerror,
                )
                self.close_bag()

    def close(self):
        with self.lock:
            self.close_bag()

    def close_bag(self):
        bag, self.bag = self.bag, None
        if bag is not None:
            with contextlib.suppress(OSError):
                bag.close()

    def run(self):
        rospy.spin()


if __name__ == "__main__":
    Record().run()
