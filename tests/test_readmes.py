"""The tables of the documentation list what the code uses."""

import os
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import yaml

from sdc_package.steering.loader import METHODS
from sdc_sim.evaluation.rules import EvaluationRules

ROOT = Path(__file__).resolve().parents[1]
SRC = ROOT / "catkin_ws" / "src"
NODES = {
    "sdc_package": ["camera", "local_planner", "mission_planner", "simple_controller"],
    "sdc_sim": ["referee", "sim"],
}
# Names, types and texts, which have no unit, and tables whose units are at the top.
WITHOUT_UNITS = {
    "street_scenarios",
    "blueprints",
    "bridge_versions",
    "building_colours",
    "hud",
    "keys",
    "meshes",
    "obstacle_kinds",
    "opendrive",
    "report_metrics",
    "report_page",
    "rviz_car",
    "scoring",
    "signs",
    "topics",
}
ALL = [(package, node) for package, nodes in NODES.items() for node in nodes]


def script(package, node):
    return (SRC / package / "scripts" / f"{node}.py").read_text(encoding="utf-8")


def code_of(package, node):
    """Return the text of a node's script and of all modules of its package that it imports."""
    texts, paths = {}, [SRC / package / "scripts" / f"{node}.py"]
    while paths:
        path = paths.pop()
        if path.exists() and path not in texts:
            texts[path] = path.read_text(encoding="utf-8")
            modules = re.findall(rf"^from ({package}\.[a-z_.]+) import", texts[path], re.MULTILINE)
            modules += re.findall(rf'import_module\("({package}\.[a-z_.]+)"\)', texts[path])
            paths += [
                SRC / package / "src" / f"{module.replace('.', '/')}.py" for module in modules
            ]
    return "\n".join(texts.values())


def parameters_of(package, node):
    """Return the names that the code reads, and those that a schema checks."""
    schema = SRC / package / "config" / "schemas" / f"{node}.yaml"
    checked = yaml.safe_load(schema.read_text(encoding="utf-8")) if schema.exists() else {}
    named = re.findall(r'\bparameter\("([a-z_0-9]+)"\)', code_of(package, node))
    return {*named, *checked} - {"definitions"}


def documentation(package):
    """Return the text of the package's README and of all pages in docs/."""
    paths = [SRC / package / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    return "\n".join(path.read_text(encoding="utf-8") for path in paths)


def topics_in(code):
    code = re.sub(r'\b(?:ego|EGO) \+ "', '"/carla/ego_vehicle', code)
    return set(re.findall(r'"(/[a-z_]+(?:/[a-z_]+)*)"', code))


@pytest.mark.parametrize("node", [*NODES["sdc_package"], "global_planner", "street_planner"])
def test_row_of_a_node_lists_its_topics(node):
    used = topics_in(script("sdc_package", node))
    readme = (SRC / "sdc_package" / "README.md").read_text(encoding="utf-8")
    row = next(line for line in readme.splitlines() if line.startswith(f"| `{node}.py`"))
    assert used
    assert used == set(re.findall(r"`(/[a-z_/]+)`", row))


@pytest.mark.parametrize("node", NODES["sdc_sim"])
def test_topics_of_the_world_are_documented(node):
    used = topics_in(code_of("sdc_sim", node))
    text = documentation("sdc_sim")
    assert used
    # The tables write a topic next to another one of the same folder as its last name alone.
    names = set(re.findall(r"([a-z_]+)`", text))
    assert sorted(topic for topic in used if topic.split("/")[-1] not in names) == []


@pytest.mark.parametrize(("package", "node"), ALL)
def test_parameters_are_documented(package, node):
    used = parameters_of(package, node)
    text = documentation(package)
    assert used
    assert sorted(name for name in used if f"`{name}`" not in text) == []


@pytest.mark.parametrize(("package", "node"), ALL)
def test_every_key_of_the_configuration_reaches_the_node(package, node):
    path = SRC / package / "config" / f"{node}.yaml"
    if not path.exists():
        pytest.skip("the launch file sets all parameters")
    pattern = r'(?<=values\.)[a-z_0-9]+|(?<=")[a-z_0-9]+(?=")'
    # On a map, street_planner.py takes the place of local_planner.py, and reads its file, too.
    readers = [node, "street_planner"] if node == "local_planner" else [node]
    named = re.findall(pattern, "".join(code_of(package, reader) for reader in readers))
    used = {*named, *METHODS, *EvaluationRules._fields}
    unused = [name for name in yaml.safe_load(path.read_text(encoding="utf-8")) if name not in used]
    assert unused == []


def test_nodes_of_the_car_restart_and_those_of_the_world_end_the_drive():
    found = {"respawn": set(), "required": set()}
    for path in sorted(SRC.glob("sdc_[sp]*/launch/*.launch")):
        for node in ElementTree.parse(path).iter("node"):
            for attribute, names in found.items():
                if node.get(attribute, "false") != "false":
                    names.add(node.get("name"))
    car = {"local_planner", "simple_controller", "camera", "carla_relay"}
    assert found["respawn"] == {*car, "front_camera", "show"}
    assert found["required"] >= {"sim", "referee", "mission_planner", "workspace_stack"}


@pytest.mark.parametrize("package", NODES)
def test_every_line_of_the_configuration_has_its_unit(package):
    for path in sorted((SRC / package / "config").glob("*.yaml")):
        if path.stem in WITHOUT_UNITS:
            continue
        lines = path.read_text(encoding="utf-8").splitlines()
        for number, line in enumerate(lines, start=1):
            opens_a_section = line.rstrip().endswith(":")
            assert "#" in line or not line.strip() or opens_a_section, (
                f"{os.path.basename(path)}, line {number}: {line}"
            )


def test_arguments_of_all_launch_are_documented():
    launch = (SRC / "sdc_package" / "launch" / "all.launch").read_text(encoding="utf-8")
    names = re.findall(r'^  <arg name="([a-z_]+)" default', launch, re.MULTILINE)
    text = (ROOT / "README.md").read_text(encoding="utf-8") + documentation("sdc_package")
    assert names
    assert [name for name in names if f"| `{name}` |" not in text] == []


def test_adapters_for_other_nodes_are_python_and_use_topics_of_the_contract():
    page = (ROOT / "docs" / "integration.md").read_text(encoding="utf-8")
    contract = (ROOT / "docs" / "bridge.md").read_text(encoding="utf-8")
    adapters = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(adapters) == 4
    for adapter in adapters:
        compile(adapter, "integration.md", "exec")
        topics = re.findall(r'"(/(?:carla|planner)/[a-z_/]+)"', adapter)
        assert topics
        assert [topic for topic in topics if f"`{topic}`" not in contract] == []


def rows_of(page, header):
    """Return the cells of the table of a page whose header has this text."""
    lines = (ROOT / "docs" / page).read_text(encoding="utf-8").split(header, 1)[1].split("\n")[2:]
    return [line.strip("| ").split(" | ") for line in lines[: lines.index("")]]


def test_table_of_the_score_has_the_numbers_of_the_configuration():
    text = (SRC / "sdc_experiments" / "config" / "championship.yaml").read_text(encoding="utf-8")
    leagues = yaml.safe_load(text)["leagues"]
    rows = rows_of("championship.md", "| part | control")
    for column, name in enumerate(("control", "driving", "traffic"), start=1):
        cells = [(row[column], row[-1]) for row in rows if row[column] != "-"]
        found = [[*map(float, re.findall(r"[\d.]+", cell)[:3]), scale] for cell, scale in cells]
        assert sorted(found) == sorted(leagues[name]["score"].values()), name


def test_table_of_road_users_has_the_shares_of_the_configuration():
    types = ElementTree.parse(SRC / "sdc_sim" / "config" / "traffic.add.xml").iter("vType")
    shares = {one.get("id"): [float(p.get("value")) for p in one.iter("param")] for one in types}
    for kinds, share, _ in rows_of("traffic.md", "| kind | share"):
        assert float(share) == sum(shares[kind][0] for kind in re.findall(r"`(.*?)`", kinds))
