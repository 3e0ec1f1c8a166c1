#!/usr/bin/env python3
"""Replay: scores a recorded drive again, from its bag, and writes the report."""

import json
import os
import sys

import rosbag
import rospy

from sdc_common.ros.node import parameter, refuse
from sdc_sim.evaluation.evaluator import EvaluationRules, Evaluator
from sdc_sim.report.console_progress import ConsoleProgress, closing_line
from sdc_sim.report.writer import ReportError, open_report, write_pages, write_report
from sdc_sim.ros.evaluator_input import EvaluatorInput


class Replay:
    def __init__(self):
        rospy.init_node("replay")
        self.bag_path = os.path.expanduser(parameter("bag"))
        self.report_path = os.path.expanduser(parameter("report"))
        self.pictures = parameter("pictures")
        self.rules = EvaluationRules.read(parameter)

    def score(self, bag):
        """The Watch that has heard the whole bag."""
        for _, message, _ in bag.read_messages("/referee/rules"):
            self.rules = EvaluationRules(**json.loads(message.data))
        watch = Evaluator(self.rules)
        listen = EvaluatorInput(watch).by_topic
        for topic, message, _ in bag.read_messages(list(listen)):
            try:
                listen[topic](message)
            except (TypeError, ValueError) as error:
                rospy.logwarn_throttle(1.0, f"replay: left out a message on {topic}: {error}")
        return watch

    def run(self):
        try:
            with rosbag.Bag(self.bag_path) as bag:
                watch = self.score(bag)
        except rosbag.ROSBagUnindexedException:
            refuse(
                f"{self.bag_path} was not closed in order; mend it with: rosbag reindex {self.bag_path}"
            )
        except (OSError, rosbag.ROSBagException) as error:
            refuse(
                f"{self.bag_path}: {getattr(error, 'strerror', None) or error}; name a recorded drive with bag:=FILE"
            )
        if watch.missing:
            refuse(f"{self.bag_path} holds no {' and no '.join(watch.missing)}")
        result = watch.result()
        try:
            open_report(self.report_path, "replay").remove()
            write_report(self.report_path, result)
            if self.pictures:
                write_pages(self.report_path, result, ())
        except ReportError as error:
            refuse(error)
        ConsoleProgress(sys.stdout).say(f"{closing_line(result.figures)}; see {self.report_path}")


if __name__ == "__main__":
    Replay().run()
