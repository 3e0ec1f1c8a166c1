"""The rules of the referee that the workshop comes with."""

import os

import numpy as np
import yaml

from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.evaluation.rules import EvaluationRules

TICK_NS = 50_000_000

_FOLDER = os.path.dirname(os.path.abspath(__file__))
with open(os.path.join(_FOLDER, "..", "config", "referee.yaml"), encoding="utf-8") as file:
    RULES = EvaluationRules.read(yaml.safe_load(file).get)


def with_route(event_file=None, length_m=100, rules=RULES):
    """Return the evaluator of a drive along x."""
    evaluator = Evaluator(rules, event_file)
    evaluator.set_route(np.column_stack([np.arange(length_m + 1.0), np.zeros(length_m + 1)]))
    return evaluator
