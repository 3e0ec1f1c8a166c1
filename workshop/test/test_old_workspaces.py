"""Workspaces that were started before maps were in sdc_map, or TODOs were given, go on working."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml
from finished_workspace import build, finished, run

from sdc_testing.street_maps import needs_maps
from sdc_workshop.steps import find_step
from sdc_workshop.workspace import PROJECT, SOLUTION

pytestmark = pytest.mark.slow(40)

IMPORTS = yaml.safe_load(Path(__file__).with_name("old_imports.yaml").read_text(encoding="utf-8"))
# Modules of sdc_map that were in sdc_sim.road.
MOVED = ("network", "network_file", "lane_graph", "mission", "opendrive_lanes")
# Modules of sdc_map that were in sdc_package, with their names there.
OF_CAR = {"crossings": "behaviour.crossings", "global_planner": "global_planner"}
# Modules of sdc_map that are newer than these workspaces.
NEWER = {"mirror"}
LAB = "behaviour"
# Steps whose lines students once wrote themselves.
GIVEN = ("controller-1.2", "mission_planner-3", "local_planner-2", "stack-launch-1")


@pytest.fixture(scope="module")
def workspace(tmp_path_factory):
    """A finished workspace of the behaviour lab, with the car; maps have their old names."""
    folder = finished(tmp_path_factory.mktemp("old") / "ws", LAB)
    library = folder / "src" / "sdc_package" / "src" / "sdc_package"
    for name, old_name in OF_CAR.items():
        new = SOLUTION / "sdc_map" / "src" / "sdc_map" / f"{name}.py"
        shutil.copy(new, library / f"{old_name.replace('.', '/')}.py")
    changed = {path.name for path in sorted((folder / "src").rglob("*.py")) if give_old_names(path)}
    assert {"global_planner.py", "crossings.py", "driver.py", "lanes.py"} <= changed
    for step in map(find_step, GIVEN):
        path = folder / "src" / step.file
        text = path.read_text(encoding="utf-8")
        assert " (given):" in text
        path.write_text(text.replace(" (given):", ":"), encoding="utf-8")
    build(folder)
    return folder


def give_old_names(path):
    """Import maps by their old names in a file; return whether it imports them."""
    text = path.read_text(encoding="utf-8")
    old = re.sub(rf"\bsdc_map\.({'|'.join(MOVED)})\b", r"sdc_sim.road.\1", text)
    for name, old_name in OF_CAR.items():
        old = old.replace(f"sdc_map.{name}", f"sdc_package.{old_name}")
    path.write_text(old, encoding="utf-8")
    assert set(re.findall(r"\bsdc_map\.(\w+)", old)) <= NEWER, path
    return old != text


def test_all_names_that_workspaces_import_are_there(workspace):
    lines = [
        f"from {module} import {', '.join(names.split())}" for module, names in IMPORTS.items()
    ]
    done = run(workspace, "python3", "-c", "\n".join(lines))
    assert done.returncode == 0, done.stdout


def test_old_and_new_names_are_the_same_modules(workspace):
    lines = ["import importlib, sdc_sim.road"]
    for name in MOVED:
        lines.append(f"old = importlib.import_module('sdc_sim.road.{name}')")
        lines.append(
            f"assert old is importlib.import_module('sdc_map.{name}') is sdc_sim.road.{name}"
        )
    done = run(workspace, "python3", "-c", "\n".join(lines))
    assert done.returncode == 0, done.stdout


@needs_maps
def test_old_command_prints_what_is_in_a_map(workspace):
    done = run(workspace, "python3", "-m", "sdc_sim.road.network_file", "town")
    assert done.stdout.startswith("town: 281 lanes for cars"), done.stdout


@needs_maps
def test_old_car_plans_on_a_map(workspace):
    nodes = workspace / "src" / "sdc_package" / "scripts"
    program = f"""
from sdc_testing import load_script
load_script("{nodes}/local_planner.py")
node = load_script("{nodes}/global_planner.py")
from sdc_behaviour import drives
from sdc_package.behaviour import street_planner
network = node.load_network("town")
mission = node.GlobalPlanner(network, [(171.45, 206.75)]).update(92.8, -302.4, 0.0)
assert mission.ends_m[-1] > 1000.0
assert street_planner.__file__.startswith("{workspace}")
assert street_planner.Network is type(network)
"""
    done = run(workspace, "python3", "-c", program)
    assert done.returncode == 0, done.stdout


def test_old_lab_and_car_pass_their_checks(workspace, sandboxed):
    done = subprocess.run(
        [PROJECT / "workshop" / "check", "behaviour-1", "behaviour-8", *GIVEN],
        cwd=workspace,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
