"""A round of the championship: resume, reveal, check by others, and its site in a browser."""

import contextlib
import hashlib
import io
import json
import re
import signal
import subprocess
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from distributed import LocalCluster
from distributed.diagnostics.plugin import SchedulerPlugin

from sdc_experiments import __main__ as sdc
from sdc_experiments.championship import rounds
from sdc_experiments.championship.driver_process import DriverServer
from sdc_experiments.sandbox import SandboxError
from sdc_testing.chromium import check_page, headless_chromium

pytestmark = pytest.mark.slow(60)
ROUND = ["sdc", "championship", "round"]
GOOD = """
class Driver:
    def __init__(self, mission):
        self.step = mission.default_car("pure_pursuit").step
"""
DRIVERS = {
    "ada": GOOD,
    "bob": GOOD.replace("pure_pursuit", "stanley"),
    "broken": "class Driver(:",
    "eve": GOOD + "\nopen('/root/secret')\n",
}


class Transitions(SchedulerPlugin):
    """Counts the steps of a cluster's tasks."""

    count = 0

    def transition(self, *_, **__):
        self.count += 1


@pytest.fixture(scope="module")
def run():
    """Return a function that runs the command in this process, which is also a cluster's worker.

    The function returns the exit status, what the command printed, and its errors.
    """
    size = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with LocalCluster(**size) as cluster, pytest.MonkeyPatch.context() as patch:
        transitions = Transitions()
        cluster.scheduler.add_plugin(transitions)

        used = []

        def run(folder, *options):
            used.append(folder)
            words = [*ROUND, str(folder), "drives:=2", "baselines:=false", *options]
            patch.setattr("sys.argv", [*words, "--scheduler", cluster.scheduler_address])
            output, errors = io.StringIO(), io.StringIO()
            with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
                status = sdc.main()
            return status, output.getvalue(), errors.getvalue()

        yield run
        assert transitions.count or not used, "the cluster had the tasks"


def scores(folder):
    paths = sorted((folder / "results").glob("*.json"))
    return {path.stem: json.loads(path.read_text())["score"] for path in paths}


@pytest.fixture(scope="module")
def held(tmp_path_factory, run):
    """Hold a round that is not revealed; skip where there is no sandbox."""
    try:
        with DriverServer(""):
            pass
    except SandboxError as error:
        pytest.skip(str(error))
    folder = tmp_path_factory.mktemp("round")
    for name, source in DRIVERS.items():
        (folder / f"{name}.py").write_text(source)
    return folder, run(folder, "reveal:=false")


def test_round_ranks_drivers_and_names_what_is_wrong(held):
    _, (status, printed, errors) = held
    assert status == 0, errors
    *_, first, second, third, fourth, last = printed.splitlines()
    assert first.split()[2] == "ada" and second.split()[2] == "bob"
    assert "broken.py, line 1" in third + fourth and "to open /root/secret" in third + fourth
    assert last.startswith("championship: control: 4 drivers, 2 drives each, see ")


def test_hash_is_public_before_the_seeds(held):
    folder, (_, printed, _) = held
    secret = (folder / "secret").read_text()
    digest = hashlib.sha256(secret.encode()).hexdigest()
    site = [path.read_text() for path in (folder / "site").iterdir()]
    seeds = rounds.seeds_of_secret(secret, "control", 2)
    assert digest in printed and any(digest in text for text in site)
    assert not any(word in text for text in site for word in (secret, *seeds))
    assert (folder / "secret").stat().st_mode & 0o077 == 0


def test_folder_holds_one_round(tmp_path):
    options = {"league": "control", "drives": 2, "secret": ""}
    about = rounds.opened(tmp_path, SimpleNamespace(**options))
    assert rounds.opened(tmp_path, SimpleNamespace(**options)) == about
    for name, value in (("league", "street"), ("drives", 3)):
        text = f"has {name}:={options[name]}, not {value}; use a new folder"
        with pytest.raises(ValueError, match=text):
            rounds.opened(tmp_path, SimpleNamespace(**{**options, name: value}))


def test_reveal_lets_anyone_repeat_the_round(held, run, tmp_path, monkeypatch):
    folder, _ = held
    before = scores(folder)
    status, printed, _ = run(folder)
    assert status == 0 and "drives/s" not in printed, "nothing is driven again"
    secret = json.loads((folder / "site/round.json").read_text())["secret"]
    index = (folder / "site/index.html").read_text()
    assert secret in index and rounds.seeds_of_secret(secret, "control", 2)[1] in index
    (tmp_path / "bob.py").write_text(DRIVERS["bob"])
    assert run(tmp_path, f"secret:={secret}", "reveal:=false")[0] == 0
    assert scores(tmp_path) == {"bob": before["bob"]}
    (folder / "late.py").write_text(GOOD)
    status, _, errors = run(folder)
    (folder / "late.py").unlink()
    assert status == 2 and "late is new or changed" in errors
    monkeypatch.setattr(rounds, "code_version", lambda: "another version of the project")
    options = {"league": "control", "drives": 2, "baselines": False}
    with pytest.raises(ValueError, match="ada is new or changed"):
        rounds.run(SimpleNamespace(folder=folder, **options))
    feed = ElementTree.parse(folder / "site/feed.xml").getroot()
    titles = [one.text for one in feed.iterfind("{*}entry/{*}title")]
    assert titles[0].startswith("ada: ") and len(titles) == 4


@pytest.mark.nightly
def test_killed_round_resumes(held, run, tmp_path):
    for name in ("ada", "bob", "cy", "dee"):
        (tmp_path / f"{name}.py").write_text(GOOD + f"# {name}\n")
    command = ["python3", "-m", "sdc_experiments", "championship", "round", str(tmp_path)]
    command += ["drives:=2", "baselines:=false", "reveal:=false"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    limit_s = time.monotonic() + 200.0
    while len(scores(tmp_path)) < 1 and time.monotonic() < limit_s and process.poll() is None:
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait()
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "results").iterdir()}
    assert 1 <= len(before) < 4
    status, _, errors = run(tmp_path, "reveal:=false")
    assert status == 0, errors
    assert len(set(scores(tmp_path).values())) == 1 and len(scores(tmp_path)) == 4
    assert {path: path.stat().st_mtime_ns for path in before} == before


def test_site_in_a_browser(held, run):
    folder, _ = held
    if "secret" not in json.loads((folder / "round.json").read_text()):
        run(folder)
    with headless_chromium(1400, 1000) as browser:
        browser.get((folder / "site/index.html").as_uri())
        rows = browser.find_elements("css selector", "table tr")
        assert [row.text.split()[1] for row in rows[1:3]] == ["ada", "bob"]
        assert "to open /root/secret" in browser.find_element("css selector", "table").text
        browser.find_element("link text", "ada").click()
        assert browser.find_element("css selector", "h1").text == "ada"
        assert len(browser.find_elements("css selector", "svg.drives rect")) == 2
        assert "class Driver" in browser.find_element("css selector", "pre").text
        browser.switch_to.frame(browser.find_element("css selector", "iframe"))
        slider = browser.find_element("css selector", "input[type=range]")
        before = browser.find_element("css selector", "body").text
        browser.execute_script(
            "arguments[0].value = 200; arguments[0].dispatchEvent(new Event('input'))", slider
        )
        assert browser.find_element("css selector", "body").text != before
        assert not [one for one in browser.get_log("browser") if one["level"] == "SEVERE"]
        browser.switch_to.default_content()
        for name in ("index", "ada"):
            check_page(browser, (folder / f"site/{name}.html").as_uri())


def test_workflow_of_the_documentation_calls_commands_that_exist():
    project = Path(__file__).resolve().parents[4]
    workflow = yaml.safe_load((project / "docs/championship_workflow.yml").read_text())
    steps = workflow["jobs"]["round"]["steps"]
    lines = "\n".join(step.get("run", "") for step in steps)
    for word in re.findall(r"workshop/([\w/]+)", lines):
        assert (project / word).is_file(), word
    assert {"learning", "mpc"} <= set(lines.split())  # a baseline needs each
    assert workflow["permissions"] == {"contents": "read"}
    assert all(re.search(r"@[0-9a-f]{40}", step["uses"]) for step in steps if "uses" in step)
