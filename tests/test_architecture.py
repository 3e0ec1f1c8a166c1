"""The packages depend on each other in one direction, and their modules in no circle."""

import ast
import re
import sys
import xml.etree.ElementTree as ElementTree
from collections import Counter
from functools import lru_cache
from pathlib import Path

import pytest

SRC = Path(__file__).resolve().parents[1] / "catkin_ws" / "src"
WORKSHOP = SRC.parents[1] / "workshop"
MESSAGES = ("ackermann_msgs", "carla_msgs", "carla_ros_bridge", "derived_object_msgs", "sdc_msgs")
LABS = ("sdc_behaviour", "sdc_localization", "sdc_mpc", "sdc_perception")
# A package imports from these, and from what they may import. World and car do not know each other.
LAYERS = {
    **dict.fromkeys(MESSAGES, ()),
    "sdc_common": MESSAGES,
    "sdc_map": ("sdc_common",),
    "sdc_sim": ("sdc_map",),
    "sdc_package": ("sdc_map",),
    **dict.fromkeys(LABS, ("sdc_sim", "sdc_package")),
    "sdc_cockpit": ("sdc_sim", "sdc_package"),
    "sdc_experiments": LABS,
}
# The same inside sdc_sim; its other modules and scripts may import from all of them.
SIM_LAYERS = {
    "yaml_document": 0,
    "physics": 1,
    "road": 2,
    "sensors": 3,
    "traffic": 3,
    "simulation": 4,
    "evaluation": 5,
    "scenario": 5,
    "camera": 6,
    "report": 6,
    "ros": 7,
    "manual_control": 8,
}
# Only these know ROS; the referee's report listens to the pictures.
WITH_ROS = {"ros", "manual_control", "report"}
# Modules that docker/prepare installs for one purpose only.
OPTIONAL = {"casadi", "gymnasium", "libsumo", "osqp", "stable_baselines3", "sumolib", "torch"}
OPTIONAL |= {"pyseccomp"}  # in the wheel; the workspace has Debian's seccomp
# Debian's packages that are not named like their module.
DEBIAN = {"PIL": "pil", "cv2": "opencv", "dask": "distributed", "ruamel": "ruamel.yaml"}
# Launch files start these only where they are in the workspace.
OPTIONAL_NODES = {*LABS, "sdc_cockpit"}
LIBRARIES = [name for name, lower in LAYERS.items() if lower]
needs_module_names = pytest.mark.skipif(
    sys.version_info < (3, 10), reason="the names of Python's own modules are known from 3.10 on"
)


def folder(package):
    in_labs = SRC / "labs" / package
    return in_labs if in_labs.is_dir() else SRC / package


def below(package):
    """Return the packages of lower layers."""
    return {name for lower in LAYERS[package] for name in (lower, *below(lower))}


def python_files(package):
    return sorted(
        path for part in ("src", "scripts") for path in (folder(package) / part).rglob("*.py")
    )


@lru_cache(maxsize=None)
def tree(path):
    return ast.parse(path.read_text(encoding="utf-8"))


def imported_modules(path):
    """Return the names of all modules and of all their members that a file imports."""
    names = set()
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}, line {node.lineno}: write an absolute import"
            names.add(node.module)
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    return names


@pytest.mark.parametrize("package", LIBRARIES)
def test_package_and_its_tests_import_only_from_lower_layers(package):
    allowed = below(package) | {package}
    for path in [*python_files(package), *sorted((folder(package) / "test").rglob("*.py"))]:
        used = {name.split(".")[0] for name in imported_modules(path)} & set(LAYERS)
        assert used <= allowed, f"{path} imports {sorted(used - allowed)}"


@pytest.mark.parametrize("part", SIM_LAYERS)
def test_part_of_the_simulator_imports_only_from_lower_layers(part):
    allowed = {name for name, layer in SIM_LAYERS.items() if layer < SIM_LAYERS[part]} | {part}
    root = SRC / "sdc_sim" / "src" / "sdc_sim"
    for path in sorted((root / part).rglob("*.py")) or [root / f"{part}.py"]:
        names = imported_modules(path)
        used = {name.split(".")[1] for name in names if name.startswith("sdc_sim.")}
        assert used <= allowed, f"{path} imports {sorted(used - allowed)}"
        assert part in WITH_ROS or "rospy" not in names, f"{path} imports rospy"


def test_simulator_imports_no_renderer():
    """Only the node of the camera paints pictures."""
    root = SRC / "sdc_sim" / "src"
    left, found = [SRC / "sdc_sim" / "scripts" / "sim.py"], set()
    while left:
        for name in imported_modules(left.pop()):
            path = root / (name.replace(".", "/") + ".py")
            if path.is_file() and path not in found:
                found.add(path)
                left.append(path)
    assert not [path for path in found if path.parent.name == "camera"]


@pytest.mark.parametrize("package", LIBRARIES)
def test_package_xml_names_no_package_of_a_higher_layer(package):
    text = (folder(package) / "package.xml").read_text(encoding="utf-8")
    higher = [name for name in LAYERS if package in below(name)]
    assert [name for name in higher if f">{name}<" in text] == []


def named(package, *tags):
    """Return the packages that tags of package.xml name."""
    root = ElementTree.parse(folder(package) / "package.xml").getroot()
    return {node.text for tag in tags for node in root.iter(tag)}


def imports(package):
    """Return what the programs and what the tests of a package import of other packages."""
    programs, tests = set(), set()
    for path in folder(package).rglob("*.py"):
        if path.name != "setup.py":
            is_test = "test" in path.parts and "sdc_testing" not in path.parts
            own = {package, *(other.stem for other in path.parent.glob("*.py"))}
            names = {name.split(".")[0] for name in imported_modules(path)} - own
            (tests if is_test else programs).update(names)
    others = {*sys.stdlib_module_names, *OPTIONAL, "sdc_testing"}
    return programs - others, tests - others


def started(package, launch_folder):
    """Return the packages whose nodes and files the launch files of a folder need."""
    place = folder(package) / launch_folder
    texts = [path.read_text() for path in (*place.glob("*.launch"), *place.glob("*.test"))]
    found = set(re.findall(r'pkg="(\w+)"|find (\w+)\)', "\n".join(texts)))
    return {name for pair in found for name in pair if name} - {package, *OPTIONAL_NODES}


def missing_and_superfluous(imported, names):
    """Compare modules with the packages that are named for them."""
    known = {name: {name, f"python3-{DEBIAN.get(name, name)}"} for name in imported}
    missing = {name for name, either in known.items() if not either & names}
    return missing, names - {name for either in known.values() for name in either}


@needs_module_names
@pytest.mark.parametrize("package", LIBRARIES)
def test_package_xml_names_what_is_imported_and_what_launch_files_start(package):
    names, tests = named(package, "exec_depend", "depend"), named(package, "test_depend")
    launched = started(package, "launch")
    assert launched <= names
    programs_import, tests_import = imports(package)
    missing, superfluous = missing_and_superfluous(programs_import, names)
    messages = {"message_runtime", "std_msgs"} if (folder(package) / "msg").is_dir() else set()
    web = {name for name in names if name.startswith("libjs-")}
    assert (missing, superfluous - launched - messages - web) == (set(), set())

    missing, _ = missing_and_superfluous(tests_import, names | tests)
    _, superfluous = missing_and_superfluous(tests_import | {"pytest"}, tests)
    assert (missing, superfluous - started(package, "test")) == (set(), set())
    assert names & tests == set()


@pytest.mark.parametrize("package", [*LIBRARIES, "sdc_workshop"])
def test_modules_have_no_import_cycle(package):
    root = WORKSHOP if package == "sdc_workshop" else folder(package) / "src"
    modules = {
        ".".join(path.relative_to(root).with_suffix("").parts): path
        for path in (root / package).rglob("*.py")
    }
    assert modules
    graph = {name: imported_modules(path) & set(modules) for name, path in modules.items()}
    while graph:
        free = [name for name, needed in graph.items() if not needed & set(graph)]
        assert free, f"these modules import each other in a circle: {sorted(graph)}"
        for name in free:
            del graph[name]


def test_no_two_classes_have_the_same_name():
    names = Counter(
        node.name
        for package in LIBRARIES
        for path in python_files(package)
        for node in ast.walk(tree(path))
        if isinstance(node, ast.ClassDef)
    )
    # `Path` is the object that the message of this name transports; sdc_common.driving has it.
    messages = {path.stem for path in SRC.rglob("*.msg")} - {"Path"}
    assert [name for name, count in names.items() if count > 1 or name in messages] == []


def test_all_packages_have_one_version_and_a_changelog():
    manifests = [
        path for path in SRC.rglob("package.xml") if not {"build", "devel"} & set(path.parts)
    ]
    versions = {re.search(r"<version>(.*)</version>", path.read_text())[1] for path in manifests}
    assert len(versions) == 1
    for path in manifests:
        changes = (path.parent / "CHANGELOG.rst").read_text(encoding="utf-8")
        assert f"Changelog for package {path.parent.name}" in changes
        assert f"\n{min(versions)} (" in changes
