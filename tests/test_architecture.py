"""The packages depend on each other in one direction, and no module or function is too long."""

import ast
from collections import Counter
from pathlib import Path

import pytest

SRC = Path(__file__).resolve().parents[1] / "catkin_ws" / "src"
# A package imports only from packages of lower layers.
LAYERS = {
    "ackermann_msgs": 0,
    "carla_msgs": 0,
    "carla_ros_bridge": 0,
    "derived_object_msgs": 0,
    "sdc_msgs": 0,
    "sdc_common": 1,
    "sdc_sim": 2,
    "sdc_package": 3,
    "sdc_localization": 4,
    "sdc_perception": 4,
    "sdc_experiments": 5,
    "sdc_cockpit": 4,
}
LIBRARIES = [name for name, layer in LAYERS.items() if layer > 0]
MAX_MODULE_LINES = 400
MAX_FUNCTION_LINES = 60


def folder(package):
    in_labs = SRC / "labs" / package
    return in_labs if in_labs.is_dir() else SRC / package


def python_files(package):
    return sorted(
        path for part in ("src", "scripts") for path in (folder(package) / part).rglob("*.py")
    )


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


def functions(path):
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef)
    return [node for node in ast.walk(tree(path)) if isinstance(node, kinds)]


@pytest.mark.parametrize("package", LIBRARIES)
def test_package_imports_only_from_lower_layers(package):
    allowed = {name for name, layer in LAYERS.items() if layer < LAYERS[package]} | {package}
    for path in python_files(package):
        used = {name.split(".")[0] for name in imported_modules(path)} & set(LAYERS)
        assert used <= allowed, f"{path} imports {sorted(used - allowed)}"


@pytest.mark.parametrize("package", LIBRARIES)
def test_package_xml_names_no_package_of_a_higher_layer(package):
    text = (folder(package) / "package.xml").read_text(encoding="utf-8")
    higher = [name for name, layer in LAYERS.items() if layer > LAYERS[package]]
    assert [name for name in higher if f">{name}<" in text] == []


@pytest.mark.parametrize("package", LIBRARIES)
def test_modules_have_no_import_cycle(package):
    root = folder(package) / "src"
    modules = {
        ".".join(path.relative_to(root).with_suffix("").parts): path for path in root.rglob("*.py")
    }
    graph = {name: imported_modules(path) & set(modules) for name, path in modules.items()}
    while graph:
        free = [name for name, needed in graph.items() if not needed & set(graph)]
        assert free, f"these modules import each other in a circle: {sorted(graph)}"
        for name in free:
            del graph[name]


@pytest.mark.parametrize("package", LIBRARIES)
def test_modules_and_functions_are_short(package):
    for path in python_files(package):
        lines = len(path.read_text(encoding="utf-8").splitlines())
        assert lines <= MAX_MODULE_LINES, f"{path} has {lines} lines"
        for function in functions(path):
            length = function.end_lineno - function.lineno + 1
            assert length <= MAX_FUNCTION_LINES, f"{path}: {function.name} has {length} lines"


def test_no_two_classes_have_the_same_name():
    names = Counter(
        node.name
        for package in LIBRARIES
        for path in python_files(package)
        for node in ast.walk(tree(path))
        if isinstance(node, ast.ClassDef)
    )
    messages = {path.stem for path in SRC.rglob("*.msg")}
    assert [name for name, count in names.items() if count > 1 or name in messages] == []
