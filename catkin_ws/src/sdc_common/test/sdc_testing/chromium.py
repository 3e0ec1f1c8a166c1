"""A headless Chromium, for tests of pages."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
import time
from pathlib import Path
from typing import Any, Callable, Iterator

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

_CHROMIUM, _DRIVER = "/usr/bin/chromium", "/usr/bin/chromedriver"
_OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
)
# On a busy machine, each command to the browser takes seconds.
LIMIT_S = 300.0


@contextlib.contextmanager
def headless_chromium(width: int = 1280, height: int = 900) -> Iterator[webdriver.Chrome]:
    """Run a browser during a block.

    Args:
        width: width of the page [pixels]
        height: height of the page [pixels]
    """
    profile = tempfile.mkdtemp(prefix="test-browser-")
    try:
        options = webdriver.ChromeOptions()
        options.binary_location = _CHROMIUM
        for option in _OPTIONS:
            options.add_argument(option)
        options.add_argument(f"--user-data-dir={profile}")
        browser = webdriver.Chrome(service=Service(_DRIVER), options=options)
        browser.set_script_timeout(LIMIT_S)
        try:
            resize(browser, width, height)
            yield browser
        finally:
            browser.quit()
    finally:
        # Its processes may still write while they end.
        shutil.rmtree(profile, ignore_errors=True)


def resize(browser: webdriver.Chrome, width: int, height: int, touch: bool = False) -> None:
    """Set the size of the page, also one smaller than a window can be, and its kind of pointer."""
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": touch})


def value_of(browser: webdriver.Chrome, expression: str) -> Any:
    """Return the value of a JavaScript expression in the page."""
    return browser.execute_script(f"return {expression}")


def wait_for(
    browser: webdriver.Chrome, expression: str, accepts: Callable[[Any], object] = bool
) -> Any:
    """Return the value of an expression when it is accepted.

    Raises:
        TimeoutError: it was not accepted within LIMIT_S
    """
    limit_s = time.monotonic() + LIMIT_S
    while True:
        value = value_of(browser, expression)
        if accepts(value):
            return value
        if time.monotonic() > limit_s:
            raise TimeoutError(f"{expression} is {value!r} after {LIMIT_S:g} s")
        time.sleep(0.1)


_AXE = Path(__file__).resolve().parents[5] / ".axe" / "node_modules" / "axe-core" / "axe.min.js"
_AXE_FAULTS = """const [done] = arguments;
axe.run({iframes: false, resultTypes: ["violations"]}).then(({violations}) => done(violations
  .filter(({impact}) => ["serious", "critical"].includes(impact))
  .map(({id, nodes}) => `${id}: ${nodes[0].html.slice(0, 200)} ${nodes[0].failureSummary}`)));"""


def check_page(browser: webdriver.Chrome, address: str) -> None:
    """Assert that a phone shows a page in its width, and that axe finds no serious fault in it.

    Without axe-core, the test is skipped after the first of both.
    """
    browser.get(address)
    resize(browser, 390, 844, touch=True)
    assert value_of(browser, "document.documentElement.scrollWidth") <= 390, address
    if not _AXE.exists():
        pytest.skip("docker/prepare axe has not been run")
    browser.execute_script(_AXE.read_text(encoding="utf-8"))
    for scheme, width in (("light", 390), ("dark", 1440)):
        resize(browser, width, 900)
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
        assert browser.execute_async_script(_AXE_FAULTS) == [], (address, scheme)
