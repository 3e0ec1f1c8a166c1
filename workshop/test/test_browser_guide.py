"""Follow the guide in JupyterLab from the first package until the camera is green."""

import subprocess

import pytest
from guide_blocks import read
from guide_student import GUIDE
from headless_browser import (
    CANVAS,
    headless_chromium,
    picture_of,
    printed_url,
    save_screenshot,
    wait_until,
)
from lab_student import LabStudent
from selenium.webdriver.common.by import By

from sdc_common.testing.processes import Program, kill_left_behind
from sdc_workshop.browser.lab import pages
from sdc_workshop.workspace import PROJECT

pytestmark = [pytest.mark.slow(60), pytest.mark.nightly]

# Standard deviation of a desktop that is not empty [0..255].
DRAWN = 20.0
# What is before drives the finished car, for minutes: a nightly run follows it in terminals.
FIRST_PACKAGE = "mkdir -p ~/practice_ws"
LAST_CHECK = "./workshop/check camera-5"
# Shows the part of the guide that the student reads, the desktop, and the terminal "work".
ARRANGE = """
const widgets = [...jupyterapp.shell.widgets("main")];
const guide = widgets.find((widget) => widget.node.querySelector(".jp-RenderedMarkdown"));
const desktop = widgets.find((widget) => widget.node.querySelector("iframe"));
jupyterapp.shell.add(desktop, "main", {ref: guide.id, mode: "split-right"});
jupyterapp.shell.add(window.terminals.work, "main", {ref: desktop.id, mode: "split-bottom"});
jupyterapp.shell.activateById(guide.id);
[...guide.node.querySelectorAll("p")].find((text) => text.innerText.startsWith(arguments[0]))
  .scrollIntoView();
"""
# Drawing the desktop without a graphics card takes much of a core.
CLOSE = """
[...jupyterapp.shell.widgets("main")].find((widget) => widget.node.querySelector("iframe"))
  .dispose();
"""
# The bar with the settings of noVNC slides out of the view.
BAR_IS_HIDDEN = """
return document.getElementById("noVNC_control_bar").getBoundingClientRect().right < 5
"""
READY = "return window.jupyterapp ? jupyterapp.restored.then(() => true) : false"


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
        with headless_chromium(1600, 1000) as student.browser:
            student.browser.get(url)
            wait_until(lambda: student.browser.execute_script(READY), "JupyterLab")
            yield student
    finally:
        service.interrupt()
        left = kill_left_behind(student.environment["ROS_MASTER_URI"])
    assert left == [], "processes were left behind"


def blocks_until_camera_is_checked():
    blocks = read(GUIDE.read_text(encoding="utf-8"))
    first, last = (
        next(index for index, block in enumerate(blocks) if text in block.text)
        for text in (FIRST_PACKAGE, LAST_CHECK)
    )
    roscore = [block for block in blocks[:first] if block.terminal == "core"]
    return [*roscore, *blocks[first : last + 2]]


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
    blocks = blocks_until_camera_is_checked()
    shows_mask = [block for block in blocks if block.window == "camera: F"][-1]
    for block in blocks:
        student.follow(block)
        if block is shows_mask:
            see_desktop(student.browser)
    assert not list((student.workspace / "src").rglob(".ipynb_checkpoints"))


def see_desktop(browser):
    """Open the desktop in a tab of JupyterLab: it shows the window of the camera."""
    browser.execute_script("jupyterapp.commands.execute('launcher:create')")
    find = browser.find_elements
    tile = ".jp-LauncherCard[title*=Desktop]"
    wait_until(lambda: find(By.CSS_SELECTOR, tile), "the tile of the desktop")[0].click()
    frame = wait_until(lambda: find(By.CSS_SELECTOR, "iframe[src*=desktop]"), "the desktop")[0]
    browser.execute_script(ARRANGE, "TODO 5: the lane filter")
    browser.switch_to.frame(frame)

    def shows_window():
        picture = picture_of(browser, CANVAS)
        return picture is not None and picture.std() > DRAWN

    wait_until(shows_window, "the picture of the window")
    wait_until(lambda: browser.execute_script(BAR_IS_HIDDEN), "a free view")
    browser.switch_to.default_content()
    save_screenshot(browser, "browser.png")
    browser.execute_script(CLOSE)
