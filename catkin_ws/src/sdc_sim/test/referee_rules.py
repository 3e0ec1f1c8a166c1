"""The rules of the referee that the workshop comes with."""

import os

import yaml

from sdc_sim.evaluation.rules import EvaluationRules

_FOLDER = os.path.dirname(os.path.abspath(__file__))
with open(os.path.join(_FOLDER, "..", "config", "referee.yaml"), encoding="utf-8") as file:
    RULES = EvaluationRules.read(yaml.safe_load(file).get)
