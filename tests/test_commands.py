"""Each command checks its words by one table, before anything is installed or built."""

import os
import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import yaml

from sdc_experiments.championship.command import BASELINES
from sdc_experiments.championship.league import LEAGUES
from sdc_experiments.commands import TABLE, WordError, known_names, parse
from sdc_package.steering.loader import METHODS
from sdc_sim.scenario.street_scenarios import types

ROOT = Path(__file__).resolve().parents[1]
COMMANDS = [name for name in TABLE if " " not in name]
WORDS = yaml.safe_load((ROOT / "tests" / "command_words.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize(("command", "words", "text"), WORDS["wrong"])
def test_wrong_word_is_named_in_one_line(command, words, text):
    with pytest.raises(WordError) as raised:
        parse(command, words.split())
    assert text in str(raised.value) and "\n" not in str(raised.value)


@pytest.fixture(scope="module")
def fresh(tmp_path_factory):
    """A copy of the commands in which nothing is built, and docker/prepare only leaves a trace."""
    root = tmp_path_factory.mktemp("fresh")
    for command in COMMANDS:
        (root / command).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / command, root / command)
    shutil.copy(ROOT / "docker" / "environment", root / "docker")
    (root / "docker" / "prepare").write_text('#!/bin/sh\necho "$@" >"$0.called"\nexit 3\n')
    (root / "catkin_ws").mkdir()
    (root / "catkin_ws" / "src").symlink_to(ROOT / "catkin_ws" / "src")
    return root


def run(root, command, *words):
    """Return the result of a command, and whether it has prepared anything."""
    called = root / "docker" / "prepare.called"
    called.unlink() if called.exists() else None
    place = ROOT if command == "docker/prepare" else root
    done = subprocess.run(
        [place / command, *words], cwd=root, capture_output=True, text=True, check=False
    )
    return done, called.exists()


@pytest.mark.parametrize("command", COMMANDS)
def test_wrong_word_ends_the_command_before_anything_is_prepared(fresh, command):
    done, prepared = run(fresh, command, "--nope=1")
    assert (done.returncode, done.stdout, prepared) == (2, "", False), done.stderr
    assert done.stderr.startswith(f"{Path(command).name}: unknown argument '--nope=1'; ")
    assert done.stderr.count("\n") == 1


def test_right_words_go_on_to_the_preparation(fresh):
    done, prepared = run(fresh, "drive", "map:=town", "seed:=3")
    assert prepared and done.returncode == 3, done.stderr


@pytest.mark.parametrize("command", COMMANDS)
def test_help_lists_every_argument_and_prepares_nothing(fresh, command):
    done, prepared = run(fresh, command, "--help")
    assert (done.returncode, done.stderr, prepared) == (0, "", False)
    text = " ".join(done.stdout.split())
    for name, entry in TABLE.items():
        if name.split()[0] == command:
            assert f"Usage: ./{name} {entry['usage']} {entry['about']}" in text
            for argument, row in entry["arguments"].items():
                assert re.search(rf"  (--)?{argument} ", done.stdout)
                assert row["about"] in text


@pytest.mark.parametrize(("command", "words"), WORDS["right"])
def test_right_words_are_accepted(command, words, monkeypatch):
    monkeypatch.chdir(ROOT)
    assert parse(command, words.split()).command.startswith(command)


def test_table_is_that_of_the_launch_files():
    for package, command, hidden in (
        ("sdc_package/launch/all.launch", "drive", {"scenario", "verbose"}),
        ("sdc_cockpit/launch/cockpit.launch", "cockpit", {"drive_command"}),
    ):
        launch = ElementTree.parse(ROOT / "catkin_ws" / "src" / package)
        rows = TABLE[command]["arguments"]
        arguments = [one for one in launch.getroot().findall("arg") if one.get("doc")]
        names = [one.get("name") for one in arguments]
        assert [name for name in names if name not in hidden] == [
            name for name in rows if name not in hidden
        ]
        for one in arguments:
            row = rows.get(one.get("name"), {"about": one.get("doc")})
            assert row["about"] == one.get("doc")
            if "$(" not in one.get("default") and one.get("name") not in hidden:
                assert row.get("default", "") == one.get("default"), one.get("name")


def names(command, argument):
    return known_names(TABLE[command]["arguments"][argument])


def test_names_of_the_table_are_those_of_the_project():
    from_steps = [*steps_of_workshop()]
    assert names("drive", "steering_method") == [*METHODS]
    assert names("scenarios", "TYPE") == [*types()]
    assert names("championship try", "league") == [*LEAGUES]
    assert names("championship baselines", "NAME") == [*BASELINES]
    assert sorted(names("workshop/check", "STEP")) == sorted(from_steps)
    script = (ROOT / "docker" / "prepare").read_text(encoding="utf-8")
    rows = re.findall(r"^        ([\w |]+)\) ", script, re.MULTILINE)
    assert sorted(names("docker/prepare", "STEP")) == sorted(" | ".join(rows).split(" | "))


def steps_of_workshop():
    for path in sorted((ROOT / "workshop").rglob("steps.yaml")):
        yield from re.findall(r"\{id: ([^,]+),", path.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("command", "program"),
    [("drive", ["roslaunch"]), ("test", ["python3", "-m", "pytest"])],
)
def test_passed_options_are_those_of_the_other_program(command, program):
    shown = subprocess.run([*program, "--help"], capture_output=True, text=True, check=True).stdout
    for option in TABLE[command]["passed"].split():
        name, takes_value = option.rstrip("="), option.endswith("=")
        pattern = rf"(?m)^ .*?(?<![\w-]){re.escape(name)}([ =][\w{{\[]| ?, --\w+[ =]\w)?"
        found = [bool(match[1]) for match in re.finditer(pattern, shown)]
        assert found, f"{name} is no option of {program[-1]}"
        assert takes_value in found, option


def test_words_reach_the_script_unchanged_and_with_absolute_paths(tmp_path):
    (tmp_path / "my route.csv").write_text("0,0\n")
    words = [
        "waypoints_path:=my route.csv",
        "report:=new/report.json",
        "sim_options:={a: 'x y', b: $(touch evil) `touch evil`}",
        "sync:=True",
        "--screen",
    ]
    script = 'source "$0"; parse drive "$@"; printf "%s\\n" "${words[@]}" "${word[cars]}"'
    done = subprocess.run(
        ["bash", "-c", script, ROOT / "docker" / "environment", *words],
        cwd=tmp_path,
        env={**os.environ, "PWD": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert sorted(done.stdout.splitlines()) == sorted(
        [
            "--screen",
            f"waypoints_path:={tmp_path}/my route.csv",
            f"report:={tmp_path}/new/report.json",
            words[2],
            "sync:=true",
            "1",
        ]
    )
    assert [path.name for path in tmp_path.iterdir()] == ["my route.csv"]


def test_values_have_the_type_of_their_row():
    found = parse("workshop/grade", [".", "--limit", "5", "--no-sandbox"])
    assert (found.dir, found.limit, found.no_sandbox, found.jobs) == (["."], 5.0, True, None)
    found = parse("championship", ["round", str(ROOT), "reveal:=false", "drives:=3"])
    assert (found.reveal, found.baselines, found.drives) == (False, True, 3)
    assert found.command == "championship round"
