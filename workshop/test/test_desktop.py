"""The desktop in the browser shows the windows of programs."""

import contextlib
import subprocess

import numpy as np
import pytest
from headless_browser import CANVAS, picture_of, save_screenshot, served, wait_until
from selenium.webdriver.common.by import By

from sdc_common.processes import matching, processes_with
from sdc_testing.chromium import headless_chromium
from sdc_testing.program import Program
from sdc_testing.virtual_display import VirtualDisplay
from sdc_workshop.workspace import PROJECT

pytestmark = pytest.mark.slow(20)

# Mean difference of the pictures, which VNC compresses with loss [0..255].
SAME = 4.0
# Standard deviation of a window that is not empty [0..255].
DRAWN = 20.0


@pytest.fixture
def desktop(tmp_path):
    with served("desktop", tmp_path) as found:
        yield found


class OtherDisplay(VirtualDisplay):
    """A display that another program has started."""

    def __init__(self, environment):
        self.environment = environment


def display_of(service):
    """Return the display that the programs of the desktop use."""
    uri = service.environment["ROS_MASTER_URI"]
    found = matching(
        processes_with("ROS_MASTER_URI", uri), lambda process: process.name() == "icewm"
    )
    return OtherDisplay(found[0].environ())


@pytest.mark.nightly
def test_desktop_in_the_browser_shows_the_window_of_rviz(desktop, monkeypatch):
    service, url = desktop
    display = display_of(service)
    monkeypatch.setenv("XAUTHORITY", display.environment["XAUTHORITY"])
    with headless_chromium() as browser:
        # Without the token there is no picture.
        browser.get(url.partition("?")[0])
        wait_until(
            lambda: browser.find_elements(By.CSS_SELECTOR, "#noVNC_status.noVNC_open"), "a refusal"
        )
        assert not browser.find_elements(By.CSS_SELECTOR, CANVAS)

        browser.get(url)
        wait_until(lambda: picture_of(browser, CANVAS) is not None, "the desktop's picture")
        rviz = Program(
            ["roslaunch", "sdc_sim", "rviz.launch"],
            {**display.environment, **service.environment},
            service.log.parent,
            service.log.parent / "rviz.log",
        )
        try:

            def draws():
                """Return whether RViz has drawn; its window may be replaced while it opens."""
                with contextlib.suppress(LookupError):
                    windows = display.windows("drive.rviz")
                    return any(display.picture(window).std() > DRAWN for window in windows)

            wait_until(draws, "RViz draws")

            def shown():
                """Return whether the page shows the screen, of which RViz's window is a part."""
                screen, page = display.picture(), picture_of(browser, CANVAS)
                same_size = page is not None and screen.shape == page.shape
                return same_size and np.abs(screen.astype(int) - page).mean() < SAME

            wait_until(shown, "the page shows what is on the screen")
            save_screenshot(browser, "desktop.png")
            assert "process has died" not in rviz.output, rviz.output
        finally:
            rviz.interrupt()


def test_menu_starts_programs_that_exist():
    from sdc_workshop.browser import desktop

    for command in filter(None, desktop.CONTENT["menu"].values()):
        words = command.partition(";")[0].split()
        if words[0] == "roslaunch":
            arguments = [word.partition(":=")[0] for word in words[3:]]
            done = subprocess.run(
                ["roslaunch", "--ros-args", *words[1:3]], capture_output=True, text=True, check=True
            )
            assert all(argument in done.stdout for argument in arguments), words
        else:
            assert (PROJECT / words[0]).is_file()
