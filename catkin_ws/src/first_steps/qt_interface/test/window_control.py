"""Mouse, keyboard and close button for tests of Qt windows on a virtual display."""

from __future__ import annotations

import contextlib
import ctypes

from sdc_common.processes import wait_until
from sdc_common.virtual_display import VirtualDisplay

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


def press_close_button(display, window):
    """Send the message that a window manager sends when its close button is clicked."""
    x11 = ctypes.CDLL("libX11.so.6")
    x11.XOpenDisplay.restype = ctypes.c_void_p
    x11.XInternAtom.restype = ctypes.c_ulong
    connection = ctypes.c_void_p(x11.XOpenDisplay(display.environment["DISPLAY"].encode()))
    event = _ClientMessage(
        type=33,
        window=int(window),
        format=32,
        message_type=x11.XInternAtom(connection, b"WM_PROTOCOLS", 0),
    )
    event.data[0] = x11.XInternAtom(connection, b"WM_DELETE_WINDOW", 0)
    x11.XSendEvent(
        connection, ctypes.c_ulong(int(window)), 0, ctypes.c_long(0), ctypes.byref(event)
    )
    x11.XCloseDisplay(connection)


class _ClientMessage(ctypes.Structure):
    """XClientMessageEvent of Xlib.h, padded to the size of an XEvent."""

    _fields_ = [
        ("type", ctypes.c_int),
        ("serial", ctypes.c_ulong),
        ("send_event", ctypes.c_int),
        ("display", ctypes.c_void_p),
        ("window", ctypes.c_ulong),
        ("message_type", ctypes.c_ulong),
        ("format", ctypes.c_int),
        ("data", ctypes.c_long * 5),
        ("padding", ctypes.c_long * 24),
    ]
