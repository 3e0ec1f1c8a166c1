#!/usr/bin/env python3
"""Replay: evaluates a recorded drive again, from its bag, and writes the report."""

import json
import os
import sys

import rosbag
import rospy

from sdc_common.ros.node import parameter, refuse
from sdc_common.ros.odometry import GROUND_TRUTH
from sdc_common.ros.refusal import refusing
from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.evaluation.rules import EvaluationRules
from sdc_sim.report.console_progress import ConsoleProgress, closing_line
from sdc_sim.report.writer import ReportError, open_report, write_pages, write_report
from sdc_sim.ros.evaluator_input import EvaluatorInput


class Replay:
    def __init__(self):
        rospy.init_node("replay")
        self.bag_path = os.path.expanduser(parameter("bag"))
        self.report_path = os.path.expanduser(parameter("report"))
        self.pictures = parameter("pictures")
        try:
            self.rules = EvaluationRules.read(parameter)
        except ValueError as error:
            refuse(f"config/referee.yaml: {error}")

    def evaluate(self, bag):
        """Return an evaluator with all messages of the bag."""
        for _, message, _ in bag.read_messages("/referee/rules"):
            self.rules = EvaluationRules(**json.loads(message.data))
        evaluator = Evaluator(self.rules)
        recorded = bag.get_type_and_topic_info().topics
        odometry_topic = GROUND_TRUTH if GROUND_TRUTH in recorded else None
        topics = EvaluatorInput(evaluator, odometry_topic=odometry_topic).topics
        for topic, message, _ in bag.read_messages(list(topics)):
            _, handle = topics[topic]
            with refusing(topic, TypeError):
                handle(message)
        return evaluator

    def run(self):
        try:
            with rosbag.Bag(self.bag_path) as bag:
                evaluator = self.evaluate(bag)
        except rosbag.ROSBagUnindexedException:
            refuse(
                f"{self.bag_path} has no index, because its recording did not end properly; "
                f"create it with: rosbag reindex {self.bag_path}"
            )
        except (OSError, rosbag.ROSBagException) as error:
            reason = getattr(error, "strerror", None) or error
            refuse(f"{self.bag_path}: {reason}; name a recorded drive with bag:=FILE")
        if not evaluator.started:
            refuse(f"{self.bag_path} has no message on {' and '.join(evaluator.missing_topics)}")
        result = evaluator.result()
        try:
            open_report(self.report_path).remove()
            write_report(self.report_path, result)
            if self.pictures:
                write_pages(self.report_path, result)
        except ReportError as error:
            refuse(error)
        line = f"{closing_line(result.metrics)}; see {self.report_path}"
        ConsoleProgress(sys.stdout).print_line(line)


if __name__ == "__main__":
    Replay().run()
