"""Read studies: the drives of a sweep, as a YAML file describes them."""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import json
import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator, NamedTuple

from sdc_common.configuration import node_config
from sdc_experiments.sweep.settings import IN_PROCESS, ROS, check_together, checked
from sdc_experiments.sweep.true_metrics import TRUE_METRICS
from sdc_sim.scenario.packaged import find_route, find_scenario
from sdc_sim.scenario.reader import load_scenario
from sdc_sim.yaml_document import YamlDocument, load_yaml, schema, validate

MAX_CELLS = 1_000_000
# What decides about the results, besides the files.
_IDENTITY = ("stack", "scenarios", "settings", "factors", "seeds")
_DEFAULT_METRICS = ("cross_track_rms_m", "driving_score")
_DEFAULT_TIMEOUT_S = 300.0


class Cell(NamedTuple):
    """One drive of a study."""

    scenario: str  # name of the scenario, or its absolute path
    settings: dict  # value of each setting
    seed: int  # seed of the noise

    @property
    def key(self) -> str:
        """Return a short name that is different for each different cell."""
        return hashlib.sha256(json.dumps(self, sort_keys=True).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Study:
    """The drives of a sweep: each combination of the factors' values with each seed."""

    path: str  # the file
    about: str  # one line for people
    stack: str  # "in_process", or "ros" for real nodes
    scenarios: tuple[str, ...]  # names or absolute paths
    settings: dict[str, Any]  # settings with the same value in each drive
    factors: dict[str, tuple]  # values of the other settings, by name
    seeds: tuple[int, ...]  # seeds of the noise
    metrics: tuple[str, ...]  # metrics of the tables and heat maps
    timeout_s: float  # wall time after which a drive with real nodes is ended [s]

    def cells(self) -> list[Cell]:
        """Return all cells; the seeds change fastest."""
        return [
            Cell(scenario, {**self.settings, **dict(zip(self.factors, values))}, seed)
            for scenario in self.scenarios
            for values in itertools.product(*self.factors.values())
            for seed in self.seeds
        ]

    def files(self) -> list[str]:
        """Return the absolute paths of the files and folders that the drives read."""
        found: list = []
        for scenario in self.scenarios:
            path = find_scenario(scenario)
            route = load_scenario(path).route
            found += [path, *([find_route(path, route)] if isinstance(route, str) else [])]
        found += self.settings.values()
        found += (value for values in self.factors.values() for value in values)
        paths = [path for path in found if isinstance(path, str) and os.path.isabs(path)]
        return list(dict.fromkeys(paths))

    def identity(self) -> dict[str, Any]:
        """Return what decides about the results, as plain data of JSON."""
        return {
            **{name: getattr(self, name) for name in _IDENTITY},
            "files": {
                path: hashlib.sha256(Path(path).read_bytes()).hexdigest()
                for path in self.files()
                if os.path.isfile(path)
            },
        }


def load_study(path: str) -> Study:
    """Read and check a study.

    Raises:
        DocumentError: the file cannot be read or is not a valid study
    """
    document = load_yaml(path, "name a readable study: sweep.py STUDY.yaml")
    if document.values is None:
        raise document.error((), "the file is empty; add 'scenarios: [town]' and 'factors:'")
    metrics = [*schema("scenario")["definitions"]["metrics"], *TRUE_METRICS]
    study_schema = node_config("sdc_experiments", "study")
    study_schema["properties"]["metrics"]["items"] = {"enum": metrics}
    validate(document, study_schema)
    values = document.values
    folder = os.path.dirname(os.path.abspath(document.path))
    stack = values.get("stack", IN_PROCESS)
    seeds = values.get("seeds", 1)

    def setting(name: str, value: Any, *keys: Any) -> Any:
        with _at(document, *keys):
            return checked(name, value, stack, folder)

    study = Study(
        document.path,
        values.get("about", ""),
        stack,
        tuple(_scenario(document, index, folder) for index in range(len(values["scenarios"]))),
        {
            name: setting(name, value, "settings", name)
            for name, value in values.get("settings", {}).items()
        },
        {
            name: tuple(setting(name, value, "factors", name, i) for i, value in enumerate(options))
            for name, options in values.get("factors", {}).items()
        },
        tuple(map(int, seeds)) if isinstance(seeds, list) else tuple(range(1, int(seeds) + 1)),
        tuple(values.get("metrics", _DEFAULT_METRICS)),
        float(values.get("timeout_s", _DEFAULT_TIMEOUT_S)),
    )
    _check_whole(document, study)
    return study


@contextlib.contextmanager
def _at(document: YamlDocument, *keys: Any) -> Iterator[None]:
    """Add the file and the line of these keys to a ValueError of the block."""
    try:
        yield
    except ValueError as error:
        raise document.error(keys, str(error)) from None


def _check_whole(document: YamlDocument, study: Study) -> None:
    for name in study.factors:
        if name in study.settings:
            raise document.error(
                ("factors", name), f"'{name}' is a setting, too; remove one of them"
            )
    for index, metric in enumerate(study.metrics):
        if study.stack == ROS and metric in TRUE_METRICS:
            problem = f"'{metric}' is measured in process; remove it or 'stack: ros'"
            raise document.error(("metrics", index), problem)
    with _at(document):
        check_together([*study.settings, *study.factors])
        factors = map(len, study.factors.values())
        count = math.prod([len(study.scenarios), len(study.seeds), *factors])
        if count > MAX_CELLS:
            most = f"at most {MAX_CELLS} are possible, remove some values"
            raise ValueError(f"these are {count} drives; {most}")


def _scenario(document: YamlDocument, index: int, folder: str) -> str:
    name = document.values["scenarios"][index]
    if name.endswith(".yaml"):
        name = os.path.normpath(os.path.join(folder, os.path.expanduser(name)))
    with _at(document, "scenarios", index):
        load_scenario(find_scenario(name))
    return name
