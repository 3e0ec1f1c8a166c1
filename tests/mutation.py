"""Run mutmut on modules of the libraries, with the unit tests that import them: see tests/mutate.

Each module is mutated in a copy of the project. mutmut leaves properties alone, so the copy writes
them without their decorator. Not mutated is what is outside of functions.
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
DOCUMENT, STORED = ROOT / "docs" / "mutants.md", ROOT / "docs" / "mutation.json"
PARTS = (
    "sdc_common",
    "sdc_package",
    "sdc_sim/physics",
    "sdc_sim/evaluation",
    "sdc_sim/scenario",
)
SLOW = re.compile(r"\bsubprocess\b|multiprocessing|isolated_ros_environment|\benvironment\b|README")
HEADER = "| module | mutants | caught | |\n|---|---|---|---|\n"
TABLE = re.compile(re.escape(HEADER) + r"(\|.*\n)*")
# Modules whose functions Numba compiles, which it cannot do with those of mutmut.
COMPILED = (
    "sdc_common.geometry.segments",
    "sdc_common.piecewise_linear",
    "sdc_sim.physics.vehicle_dynamics",
    "sdc_sim.physics.vehicle_motion",
)
CAUGHT, TOO_LONG = {1, 3, -11}, {-24, 24, 36, 152, 255}  # exit codes of mutmut
MUTMUT = [str(Path(sys.executable).with_name("mutmut"))]
# mutmut signals each process whose time is over, also when its number is that of another by then.
CONFINED = [
    *("bwrap", "--dev-bind", "/", "/", "--proc", "/proc"),
    *("--unshare-pid", "--die-with-parent"),
]
QUICK = "not slow and not nightly"
SETTINGS = """
[tool.mutmut]
source_paths = ["src/"]
only_mutate = [{mutated}]
also_copy = ["catkin_ws", "data", "conftest.py"]
pytest_add_cli_args = ["-m", {marks}]
pytest_add_cli_args_test_selection = {tests}
track_dependencies = false
use_git_change_detection = false
timeout_multiplier = 20.0

[tool.pytest.ini_options]
addopts = "-q -p no:cacheprovider -p no:xdist --import-mode=importlib --assert=plain -k 'not fuzz'"
markers = ["slow", "nightly"]
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
    """Return lists of test files, to be tried one after the other: an empty one has no such tests.

    First those with the name of the module in theirs, at least two with those of modules that
    import it. Then those that import it and, if these are few, those of its users. Then those that
    start programs.
    """
    tests = [
        path
        for folder in ("sdc_common", "sdc_sim", "sdc_package")
        for path in sorted((SRC / folder / "test").glob("test_*.py"))
    ]
    fast = [path for path in tests if not SLOW.search(path.read_text(encoding="utf-8"))]
    own = [path for path in tests if path.is_relative_to(SRC / module.partition(".")[0])]

    def named(user, path):
        return user.rpartition(".")[2] in path.stem and imports(user, path)

    return [
        _first_of(module, fast, named, 2),
        _first_of(module, fast, imports, 3),
        _first_of(module, own, imports, 1),
    ]


def _first_of(module, tests, belongs, enough):
    """Return the tests that belong to a module, and to its users until there are enough."""
    users, seen, found = [module], set(), set()
    while users and len(found) < enough:
        found.update(path for path in tests if any(belongs(user, path) for user in users))
        seen.update(users)
        users = [
            one
            for one in all_modules()
            if one not in seen and any(imports(user, path_of(one)) for user in users)
        ]
    return sorted(str(path.relative_to(ROOT)) for path in found)


def without_properties(text):
    """Return code that does the same without the decorator `@property`."""
    lines = text.splitlines()
    insert = {}  # line number -> line after it
    for node in ast.walk(ast.parse(text)):
        for decorator in getattr(node, "decorator_list", ()):
            if ast.unparse(decorator) == "property":
                lines[decorator.lineno - 1] = ""
                line = " " * node.col_offset + f"{node.name} = property({node.name})"
                insert[node.end_lineno] = line
    result = []
    for number, line in enumerate(lines, start=1):
        result += [line, insert[number]] if number in insert else [line]
    return "\n".join([*result, ""])


def copy_project(folder, module, tests, marks):
    kept = shutil.ignore_patterns("*.pyc", "__pycache__", "build", "devel")
    shutil.copytree(SRC, folder / "catkin_ws" / "src", ignore=kept)
    shutil.copytree(ROOT / "data", folder / "data", ignore=kept)
    shutil.copy(ROOT / "conftest.py", folder)
    for package in ("sdc_common", "sdc_sim", "sdc_package"):
        shutil.move(
            str(folder / "catkin_ws/src" / package / "src" / package), folder / "src" / package
        )
    messages = ROOT / "catkin_ws/devel/lib/python3/dist-packages/sdc_package/msg"
    shutil.copytree(messages, folder / "src" / "sdc_package" / "msg")
    if module in COMPILED:
        (folder / "src" / "numba.py").write_text("raise ImportError\n", encoding="utf-8")
    mutated = folder / "src" / (module.replace(".", "/") + ".py")
    mutated.write_text(without_properties(mutated.read_text(encoding="utf-8")), encoding="utf-8")
    settings = SETTINGS.format(
        mutated=json.dumps(str(mutated.relative_to(folder))),
        tests=json.dumps(tests),
        marks=json.dumps(marks),
    )
    (folder / "pyproject.toml").write_text(settings, encoding="utf-8")
    return Path("mutants") / (str(mutated.relative_to(folder)) + ".meta")


def mutate(module):
    """Return the number of mutants, the survivors and those that take too long; None: no tests."""
    named, fast, starting = tests_of(module)
    # Each survivor takes the time of all tests: the slow ones only where no others run the code.
    for tests, marks in ((named, QUICK), (fast, QUICK), (fast, "not nightly"), (starting, QUICK)):
        result = _mutate(module, tests, marks) if tests else None
        if result is not None:
            return result
    return None


def _mutate(module, tests, marks):
    with tempfile.TemporaryDirectory(prefix="mutation_") as name:
        folder = Path(name)
        (folder / "src").mkdir()
        meta = copy_project(folder, module, tests, marks)
        done = subprocess.run(
            [*CONFINED, *MUTMUT, "run"],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        if "could not find any test case" in done.stdout or "returned 5" in done.stdout:
            return None
        if not (folder / meta).exists() or "Running mutation testing" not in done.stdout:
            said = re.sub("^[\u2800-\u28ff].*\n", "", done.stdout, flags=re.MULTILINE)
            sys.exit(f"mutate: {module}: mutmut ended with {done.returncode}\n{said[-5000:]}")
        codes = json.loads((folder / meta).read_text(encoding="utf-8"))["exit_code_by_key"]

        def differences(mutants):
            return {mutant.rpartition(".")[2]: _difference(mutant, folder) for mutant in mutants}

        survivors = differences(key for key, code in codes.items() if code not in CAUGHT | TOO_LONG)
        too_long = differences(key for key, code in codes.items() if code in TOO_LONG)
        return len(codes), survivors, too_long


def _difference(mutant, folder):
    """Return the lines that a mutant changes."""
    shown = subprocess.run(
        [*MUTMUT, "show", mutant], cwd=folder, stdout=subprocess.PIPE, text=True
    ).stdout
    return "\n".join(re.findall(r"^[-+](?![-+]).*", shown, re.MULTILINE))


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
    if not shutil.which("bwrap") or subprocess.run([*CONFINED, "true"]).returncode:
        sys.exit("mutate: needs bubblewrap, and a system that permits it a process namespace")
    stored = json.loads(STORED.read_text(encoding="utf-8")) if STORED.is_file() else {}
    for module in modules or all_modules():
        result = mutate(module)
        if result is None:
            print(f"mutate: {module}: no unit test runs its functions", flush=True)
            continue
        count, survivors, too_long = result
        for name, difference in survivors.items():
            print(f"{name}\n{difference}")
        for name, difference in too_long.items():
            print(f"{name} (caught: takes too long)\n{difference}")
        print(f"mutate: {module}: {count - len(survivors)} of {count} caught", flush=True)
        stored[module] = {"mutants": count, "caught": count - len(survivors)}
        stored = dict(sorted(stored.items()))
        STORED.write_text(json.dumps(stored, indent=1) + "\n", encoding="utf-8")
        page = TABLE.sub(table(stored), DOCUMENT.read_text(encoding="utf-8"))
        DOCUMENT.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    os.nice(10)
    main(sys.argv[1:])
