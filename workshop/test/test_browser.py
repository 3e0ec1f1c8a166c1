"""The command ./workshop/browser: what it serves, where, and its errors."""

import json
import os
import re
import socket
import stat
import subprocess
from pathlib import Path

import pytest

from sdc_workshop import progress
from sdc_workshop.browser import lab, service
from sdc_workshop.exam.answer import PASSED
from sdc_workshop.steps import load_steps
from sdc_workshop.workspace import PROJECT


def run(*arguments):
    return subprocess.run(
        ["/usr/bin/python3", "-B", "-m", "sdc_workshop.browser.lab", *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": f"{PROJECT / 'workshop'}:{os.environ['PYTHONPATH']}"},
        capture_output=True,
        text=True,
        check=False,
    )


def test_token_is_in_a_file_that_only_its_owner_can_read(tmp_path):
    lab.write_configuration(tmp_path, Path("/"), {"ip": "127.0.0.1"}, "secret", {})
    file = tmp_path / "jupyter_server_config.json"
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    values = json.loads(file.read_text(encoding="utf-8"))
    assert values["IdentityProvider"]["token"] == "secret"
    for cookies in (
        values["IdentityProvider"]["cookie_options"],
        values["ServerApp"]["tornado_settings"]["xsrf_cookie_kwargs"],
    ):
        assert cookies["samesite"] == "Strict"
    assert values["ServerApp"]["terminado_settings"]["shell_command"][-1] == "/bin/bash"


def test_first_page_has_buttons_for_a_drive_the_cockpit_and_the_next_step(tmp_path):
    package = tmp_path / "src" / "sdc_package"
    package.mkdir(parents=True)
    first, second = load_steps()[:2]
    (package / progress.NAME).write_text(json.dumps({first.id: PASSED}))
    guide = lab.local_guide("http://x/cockpit/?token=t", tmp_path)
    assert re.findall(r"\[<kbd>(.+?)</kbd>\]\((.+?)\)", guide.read_text(encoding="utf-8")) == [
        ("Watch a drive", "http://x/cockpit/?token=t&drive"),
        ("Cockpit", "http://x/cockpit/?token=t"),
        (f"Next step: {second.title}", "<Phase 2.md>"),
    ]
    assert stat.S_IMODE(guide.stat().st_mode) == 0o600, "it has the token"


def test_port_that_is_taken_is_not_used():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert service.free_port("127.0.0.1", port) > port


@pytest.mark.slow(3)
@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        (["drive"], "browser: {cwd}/drive is a file; name the folder of your workspace"),
        (["no/ws"], "browser: {cwd}/no does not exist; create it, or name another workspace"),
        (["--ip", "203.0.113.1"], "no port is free on 203.0.113.1 from 8888 on"),
    ],
)
def test_mistake_is_one_line(arguments, error, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "drive").touch()
    done = run(*arguments)
    assert done.returncode != 0 and "Traceback" not in done.stderr
    assert error.format(cwd=tmp_path) in done.stderr.splitlines()[-1]
