"""A virtual display for tests of Qt windows."""

import contextlib

from sdc_common.processes import wait_until
from sdc_testing.virtual_display import VirtualDisplay

WINDOW_TIMEOUT_S = 30.0  # from the start of a node to its window


@contextlib.contextmanager
def qt_display(width=1200, height=760):
    """Run a virtual display on which Qt programs open their windows."""
    with VirtualDisplay(width, height) as display:
        display.environment["QT_QPA_PLATFORM"] = "xcb"
        yield display


def find_window(display, title):
    """Wait for the window whose title contains `title`, focus it and return its id."""
    window = wait_until(
        lambda: display.windows(title), WINDOW_TIMEOUT_S, f"a window called {title!r}"
    )[0]
    display.xdotool("windowfocus", "--sync", window)
    return window
