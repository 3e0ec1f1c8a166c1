"""The rules of the referee that the workshop comes with."""

import numpy as np

from sdc_common.configuration import node_config
from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.evaluation.rules import EvaluationRules

TICK_NS = 50_000_000
RULES = EvaluationRules.read(node_config("sdc_sim", "referee").get)


def with_route(event_file=None, length_m=100, rules=RULES):
    """Return the evaluator of a drive along x."""
    evaluator = Evaluator(rules, event_file)
    evaluator.set_route(np.column_stack([np.arange(length_m + 1.0), np.zeros(length_m + 1)]))
    return evaluator
