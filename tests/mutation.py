"""Run mutmut on modules of the libraries, with the unit tests that import them: see tests/mutate.

Each module is mutated in a copy of the project. mutmut leaves decorated code alone, so the copy
writes dataclasses and properties without a decorator. Not mutated are methods of named tuples,
class methods, static methods, and what is outside of functions.
"""

import ast
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SRC = ROOT / "catkin_ws" / "src"
DOCUMENT, STORED = ROOT / "docs" / "testing.md", ROOT / "docs" / "mutation.json"
PARTS = (
    "sdc_common",
    "sdc_package",
    "sdc_sim/physics",
    "sdc_sim/evaluation",
    "sdc_sim/scenario",
)
# Tests that start programs take too long for thousands of runs.
SLOW = re.compile(r"\bsubprocess\b|multiprocessing|isolated_ros_environment|\benvironment\b")
HEADER = "| module | mutants | caught | |\n|---|---|---|---|\n"
TABLE = re.compile(re.escape(HEADER) + r"(\|.*\n)*")
CAUGHT = {1, 3, -24, 24, 36, 152, 255, -11}  # exit codes of mutmut: a test failed, or a timeout
SETTINGS = """
[tool.mutmut]
paths_to_mutate = ["src/"]
do_not_mutate = {others}
also_copy = ["catkin_ws", "data", "conftest.py"]
tests_dir = {tests}

[tool.pytest.ini_options]
addopts = "-q -p no:cacheprovider -p no:xdist --import-mode=importlib -k 'not fuzz'"
"""


def path_of(module):
    return SRC / module.partition(".")[0] / "src" / (module.replace(".", "/") + ".py")


def all_modules():
    found = []
    for part in PARTS:
        root = SRC / part.partition("/")[0] / "src"
        for path in sorted((root / part).rglob("*.py")):
            if path.name != "__init__.py" and "testing" not in path.parts:
                found.append(".".join(path.relative_to(root).with_suffix("").parts))
    return found


def imports(module, path):
    """Return whether a file imports a module."""
    package, _, name = module.rpartition(".")
    return re.search(
        rf"(from|import) {re.escape(module)}\b|from {re.escape(package)} import .*\b{name}\b",
        path.read_text(encoding="utf-8"),
    )


def tests_of(module):
    """Return the fast tests that import a module, else those of the modules that import it."""
    tests = [
        path
        for folder in ("sdc_common", "sdc_sim", "sdc_package")
        for path in sorted((SRC / folder / "test").glob("test_*.py"))
        if not SLOW.search(path.read_text(encoding="utf-8"))
    ]
    found = [path for path in tests if imports(module, path)]
    if not found:
        users = [one for one in all_modules() if imports(module, path_of(one))]
        found = [path for path in tests if any(imports(user, path) for user in users)]
    return [str(path.relative_to(ROOT)) for path in found]


def without_decorators(text):
    """Return code that does the same without `@dataclass` and `@property`."""
    lines = text.splitlines()
    insert = {}  # line number -> lines before it
    for node in ast.walk(ast.parse(text)):
        for decorator in getattr(node, "decorator_list", ()):
            call = ast.unparse(decorator)
            if call.partition("(")[0] in ("dataclass", "property"):
                lines[decorator.lineno - 1 : decorator.end_lineno] = [
                    "" for _ in range(decorator.lineno, decorator.end_lineno + 1)
                ]
                line = " " * node.col_offset + f"{node.name} = {call}({node.name})"
                insert.setdefault(node.end_lineno + 1, []).append(line)
        if isinstance(node, ast.ClassDef) and "NamedTuple" in map(ast.unparse, node.bases):
            for method in node.body:
                if isinstance(method, ast.FunctionDef):
                    first = min([method.lineno, *(one.lineno for one in method.decorator_list)])
                    line = " " * method.col_offset + "@(lambda function: function)"
                    insert.setdefault(first, []).append(line)
    result = []
    for number, line in enumerate([*lines, ""], start=1):
        # The end of a method comes before that of its class.
        result += sorted(insert.get(number, ()), key=lambda one: len(one.lstrip()) - len(one))
        result.append(line)
    return "\n".join(result)


def copy_project(folder, module, tests):
    kept = shutil.ignore_patterns("*.pyc", "__pycache__", "build", "devel")
    shutil.copytree(SRC, folder / "catkin_ws" / "src", ignore=kept)
    shutil.copytree(ROOT / "data", folder / "data", ignore=kept)
    shutil.copy(ROOT / "conftest.py", folder)
    names = []
    for package in ("sdc_common", "sdc_sim", "sdc_package"):
        shutil.move(
            str(folder / "catkin_ws/src" / package / "src" / package), folder / "src" / package
        )
        names += [
            str(path.relative_to(folder)) for path in (folder / "src" / package).rglob("*.py")
        ]
    messages = ROOT / "catkin_ws/devel/lib/python3/dist-packages/sdc_package/msg"
    (folder / "src" / "sdc_package" / "msg").symlink_to(messages)
    mutated = folder / "src" / (module.replace(".", "/") + ".py")
    mutated.write_text(without_decorators(mutated.read_text(encoding="utf-8")), encoding="utf-8")
    others = sorted(set(names) - {str(mutated.relative_to(folder))})
    settings = SETTINGS.format(others=json.dumps(others), tests=json.dumps(tests))
    (folder / "pyproject.toml").write_text(settings, encoding="utf-8")
    return Path("mutants") / (str(mutated.relative_to(folder)) + ".meta")


def mutate(module):
    """Return the number of mutants and the survivors with their differences; None: no tests."""
    tests = tests_of(module)
    if not tests:
        return None
    mutmut = [str(Path(sys.executable).with_name("mutmut"))]
    with tempfile.TemporaryDirectory(prefix="mutation_") as name:
        folder = Path(name)
        (folder / "src").mkdir()
        meta = copy_project(folder, module, tests)
        done = subprocess.run(
            [*mutmut, "run"],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        if not (folder / meta).exists() or "Running mutation testing" not in done.stdout:
            sys.exit(
                f"mutate: {module}: mutmut ended with {done.returncode}\n{done.stdout[-5000:]}"
            )
        codes = json.loads((folder / meta).read_text(encoding="utf-8"))["exit_code_by_key"]
        survivors = {}
        for mutant in (key for key, code in codes.items() if code not in CAUGHT):
            shown = subprocess.run(
                [*mutmut, "show", mutant], cwd=folder, stdout=subprocess.PIPE, text=True
            ).stdout
            changed = re.findall(r"^[-+](?![-+]).*", shown, re.MULTILINE)
            survivors[mutant.rpartition(".")[2]] = "\n".join(changed)
        return len(codes), survivors


def table(stored):
    """Return the rows of docs/testing.md."""
    rows = [
        f"| `{module}` | {one['mutants']} | {one['caught']} | {_percent([one])} |\n"
        for module, one in stored.items()
    ]
    total, caught = (sum(one[key] for one in stored.values()) for key in ("mutants", "caught"))
    return HEADER + "".join(
        [*rows, f"| all of these | {total} | {caught} | {_percent(stored.values())} |\n"]
    )


def _percent(results):
    total, caught = (sum(one[key] for one in results) for key in ("mutants", "caught"))
    return f"{100.0 * caught / max(total, 1):.0f} %"


def main(modules):
    unknown = [module for module in modules if not path_of(module).is_file()]
    if unknown:
        sys.exit(f"mutate: there is no module {unknown[0]}; there are {', '.join(all_modules())}")
    stored = json.loads(STORED.read_text(encoding="utf-8")) if STORED.is_file() else {}
    for module in modules or all_modules():
        result = mutate(module)
        if result is None:
            print(f"mutate: {module}: no unit test imports it", flush=True)
            continue
        count, survivors = result
        for name, difference in survivors.items():
            print(f"{name}\n{difference}")
        print(f"mutate: {module}: {count - len(survivors)} of {count} caught", flush=True)
        stored[module] = {"mutants": count, "caught": count - len(survivors)}
        stored = dict(sorted(stored.items()))
        STORED.write_text(json.dumps(stored, indent=1) + "\n", encoding="utf-8")
        page = TABLE.sub(table(stored), DOCUMENT.read_text(encoding="utf-8"))
        DOCUMENT.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    os.nice(10)
    main(sys.argv[1:])
