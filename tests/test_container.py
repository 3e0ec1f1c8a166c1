"""The image, the bare systems and CI install the same packages for the same releases of Debian."""

import json
import re
import subprocess
from pathlib import Path

import pytest
import yaml

pytestmark = pytest.mark.slow(8)

ROOT = Path(__file__).resolve().parents[1]
RELEASES = ("bookworm", "trixie")


def read(name):
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_same_releases_are_tried_everywhere():
    matrix = yaml.safe_load(read(".github/workflows/test.yml"))["jobs"]["test"]["strategy"][
        "matrix"
    ]
    assert tuple(matrix["debian"]) == RELEASES
    assert " | ".join(RELEASES) + ")" in read("docker/try-on")
    assert f"ARG DEBIAN={RELEASES[0]}" in read("docker/Dockerfile")


def test_downloads_are_pinned_by_digest():
    """A tag or a version on a server can get another content."""
    images = re.findall(r"^FROM (\S+:\S+)", read("docker/Dockerfile"), re.MULTILINE)
    assert [image for image in images if not re.search(r"@sha256:[0-9a-f]{64}$", image)] == []
    assert len(images) == len(RELEASES)
    actions = re.findall(r"uses: (\S+)", read(".github/workflows/test.yml"))
    assert [action for action in actions if not re.search(r"@[0-9a-f]{40}$", action)] == []
    for path in {*ROOT.glob("docker/*-packages.txt")} - {ROOT / "docker" / "apt-packages.txt"}:
        packages = path.read_text().replace("\\\n", "").splitlines()
        package = re.compile(r"[\w.-]+==[\w.]+( +--hash=sha256:[0-9a-f]{64})+")
        assert [one for one in packages if one[0] != "#" and not package.fullmatch(one)] == []


def test_release_that_is_not_known_is_refused():
    done = subprocess.run(
        [ROOT / "docker" / "try-on", "potato"], stderr=subprocess.PIPE, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (
        2,
        "try-on: usage: docker/try-on bookworm|trixie [COMMAND ...]\n",
    )


def test_container_of_an_editor_is_built_from_the_image():
    settings = json.loads(read(".devcontainer/devcontainer.json"))
    dockerfile = ROOT / ".devcontainer" / settings["build"]["dockerfile"]
    assert dockerfile.resolve() == ROOT / "docker" / "Dockerfile"
    workdir, user = (
        re.findall(rf"^{word} (\S+)", read("docker/Dockerfile"), re.MULTILINE)[-1]
        for word in ("WORKDIR", "USER")
    )
    assert (settings["workspaceFolder"], settings["remoteUser"]) == (workdir, user)


@pytest.mark.parametrize("name, port", [("workshop", 8888), ("desktop", 6080)])
def test_page_of_the_container_is_reached_from_this_machine_only(name, port):
    compose = yaml.safe_load(read("docker/compose.yaml"))
    service = compose["services"][name]
    assert service["ports"] == [f"127.0.0.1:{port}:{port}"]
    assert service["volumes"] == ["home:/home/driver"] and "home" in compose["volumes"]
    program = service["command"][0]
    assert program.startswith("/workshop/") and (ROOT / program[len("/workshop/") :]).is_file()
    help_ = subprocess.run(
        [ROOT / program[len("/workshop/") :], "--help"], capture_output=True, text=True, check=True
    ).stdout
    assert f"free (default: {port})" in " ".join(help_.split())
