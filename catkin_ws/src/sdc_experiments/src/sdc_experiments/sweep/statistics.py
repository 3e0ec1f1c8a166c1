"""Means and confidence intervals of the drives of a study."""

from __future__ import annotations

import math
from typing import Any, Iterable, Mapping, NamedTuple, Sequence

import numpy as np
from scipy import stats

from sdc_experiments.sweep.results import FAILED
from sdc_experiments.sweep.settings import text
from sdc_sim.evaluation.route_progress import COMPLETED

CONFIDENCE = 0.95
# Of a drive that was not completed, other metrics describe a shorter drive.
_OF_EACH_DRIVE = ("route_completion_percent", "driving_score")


class MeanEstimate(NamedTuple):
    """A mean over seeds, and half of the width of its confidence interval."""

    mean: float  # the mean, NaN without a value
    half_width: float  # NaN with fewer than two values


class Combination(NamedTuple):
    """The drives that differ only in their seeds."""

    scenario: str  # the scenario
    values: dict[str, Any]  # value of each factor
    drives: int  # number of drives
    completed: int  # number of drives that were completed
    failed: int  # number of cells that failed
    metrics: dict[str, MeanEstimate]  # estimate of each metric


def estimate(values: Sequence[float]) -> MeanEstimate:
    """Return the mean of values, and its confidence interval by Student's t distribution."""
    count = len(values)
    mean = float(np.mean(values)) if count else math.nan
    if count < 2:
        return MeanEstimate(mean, math.nan)
    quantile = float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, count - 1))
    return MeanEstimate(mean, quantile * float(np.std(values, ddof=1)) / math.sqrt(count))


def combinations(
    rows: Iterable[Mapping], factors: Iterable[str], metrics: Sequence[str]
) -> list[Combination]:
    """Return the combinations of scenario and factors in the order of the rows."""
    factors = list(factors)
    groups: dict[tuple, list[Mapping]] = {}
    for row in rows:
        values = (text(row["settings"][name]) for name in factors)
        groups.setdefault((row["scenario"], *values), []).append(row)
    found = []
    for (scenario, *_), group in groups.items():
        driven = [row for row in group if row["status"] != FAILED]
        completed = [row for row in driven if row["status"] == COMPLETED]
        found.append(
            Combination(
                scenario,
                {name: group[0]["settings"][name] for name in factors},
                len(driven),
                len(completed),
                len(group) - len(driven),
                {
                    name: estimate(_values(driven if name in _OF_EACH_DRIVE else completed, name))
                    for name in metrics
                },
            )
        )
    return found


def _values(rows: Iterable[Mapping], name: str) -> list[float]:
    values = (row["metrics"].get(name) for row in rows)
    return [float(value) for value in values if value is not None]
