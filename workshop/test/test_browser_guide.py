"""Follow the guide in JupyterLab until the checks of the camera are green."""

import os
import subprocess

import pytest
from guide_student import GUIDE
from headless_browser import headless_chromium, printed_url, wait_until
from lab_student import LabStudent

from sdc_common.testing.processes import Program, kill_left_behind
from sdc_workshop.browser.lab import pages
from sdc_workshop.guide import read
from sdc_workshop.workspace import PROJECT

pytestmark = pytest.mark.slow(120)

LAST_CHECK = "./workshop/check camera-5"
READY = "return window.jupyterapp !== undefined && await jupyterapp.restored !== null"


@pytest.fixture(scope="module")
def jupyterlab():
    done = subprocess.run(
        [PROJECT / "docker" / "prepare", "browser"], stderr=subprocess.PIPE, text=True, check=False
    )
    if done.returncode != 0:
        pytest.skip(f"JupyterLab could not be installed: {done.stderr.splitlines()[-1]}")


@pytest.fixture
def student(jupyterlab, tmp_path):
    root, _ = pages(tmp_path / "sdc_ws")
    student = LabStudent(tmp_path, root)
    service = Program(
        [PROJECT / "workshop" / "browser"], student.environment, tmp_path, tmp_path / "log"
    )
    try:
        url = printed_url(service, "browser")
        with headless_chromium() as student.browser:
            student.browser.get(url)
            wait_until(lambda: student.browser.execute_script(READY), "JupyterLab")
            yield student
            screenshot(student.browser, "browser.png")
            for terminal in student.terminals.values():
                terminal.interrupt()
    finally:
        service.interrupt()
        left = kill_left_behind(student.environment["ROS_MASTER_URI"])
    assert left == [], "processes were left behind"


def screenshot(browser, name):
    """Save a picture of the page, if SCREENSHOTS names a folder."""
    if "SCREENSHOTS" in os.environ:
        browser.save_screenshot(os.path.join(os.environ["SCREENSHOTS"], name))


def blocks_until_camera_is_checked():
    blocks = read(GUIDE.read_text(encoding="utf-8"))
    last = next(index for index, block in enumerate(blocks) if LAST_CHECK in block.text)
    return blocks[: last + 2]


def test_guide_is_followed_in_jupyterlab_until_the_camera_is_green(student):
    guide = "document.querySelector('.jp-RenderedMarkdown')?.innerText"
    wait_until(
        lambda: (
            "Write a self-driving car" in (student.browser.execute_script(f"return {guide}") or "")
        ),
        "the rendered guide",
    )
    student.look_for_display()
    _, python = student.terminal("work").run("which python3; echo ${VIRTUAL_ENV-none}")
    assert python.split() == ["/usr/bin/python3", "none"]
    for block in blocks_until_camera_is_checked():
        student.follow(block)
