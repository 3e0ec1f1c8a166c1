"""A server with the address that it prints, and what a browser shows of its page."""

import contextlib
import os

import cv2
import numpy as np
from selenium.common.exceptions import NoSuchElementException, StaleElementReferenceException
from selenium.webdriver.common.by import By

from sdc_common import processes
from sdc_testing.program import Program
from sdc_workshop.workspace import PROJECT

LIMIT_S = 180.0
# What noVNC draws on.
CANVAS = "#noVNC_container canvas"


def wait_until(condition, what):
    """Return the first true value of a condition."""
    return processes.wait_until(condition, LIMIT_S, what)


@contextlib.contextmanager
def served(name, folder):
    """Run ./workshop/NAME at home in a folder; yield the program and the URL that it prints."""
    with processes.isolated_ros_environment(folder / "ros") as environment:
        environment = {**environment, "HOME": str(folder), "LC_ALL": "C.UTF-8"}
        environment.pop("DISPLAY", None)
        service = Program([PROJECT / "workshop" / name], environment, folder, folder / "log")
        try:
            yield service, service.wait_for_match(rf"(?m)^{name}: (http://\S+)\s")
        finally:
            service.interrupt()


def picture_of(browser, selector):
    """Return what the page shows of an element, as (H, W, 3) BGR uint8; None without one."""
    try:
        element = browser.find_element(By.CSS_SELECTOR, selector)
        if 0 in element.size.values():
            return None
        return cv2.imdecode(np.frombuffer(element.screenshot_as_png, np.uint8), cv2.IMREAD_COLOR)
    except (NoSuchElementException, StaleElementReferenceException):
        # The page is not complete, or is loaded again.
        return None


def save_screenshot(browser, name):
    """Save a picture of the page, if the environment variable SCREENSHOTS names a folder."""
    if "SCREENSHOTS" in os.environ:
        browser.save_screenshot(os.path.join(os.environ["SCREENSHOTS"], name))
