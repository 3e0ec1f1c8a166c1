"""A screen that nobody sees, for the tests of the window: what VirtualDisplay does, and what Qt's windows need besides."""

from __future__ import annotations

import ctypes

from sdc_package.listening import wait_until
from sdc_package.virtual_display import VirtualDisplay

WINDOW_SECONDS = 30.0  # at most, from a node's start to its window


class VirtualScreen(VirtualDisplay):
    """Lives from its making until stop(), or the end of its `with`."""

    def __init__(self, width=1200, height=760):
        super().__init__(width, height)
        super().__enter__()
        self.display = self.environment["DISPLAY"]
        self.environment["QT_QPA_PLATFORM"] = "xcb"
        self.environment.pop("WAYLAND_DISPLAY", None)

    def __enter__(self):
        return self

    def stop(self):
        """Ends the X server."""
        self.__exit__()

    def xdotool(self, *arguments):
        """Runs xdotool, which moves the screen's mouse and presses its keys."""
        self._xdotool(*map(str, arguments), check=True)

    def find_window(self, name):
        """The id of the window with this name, as soon as it is shown; gives it the keyboard."""
        window = wait_until(
            lambda: self.windows(name), WINDOW_SECONDS, f"a window called {name!r}"
        )[0]
        self.xdotool("windowfocus", "--sync", window)
        return window

    def click(self, x, y, button=1):
        """Moves the mouse to the pixel of the screen and clicks; button 4 and 5 are the wheel up and down."""
        self.xdotool("mousemove", x, y, "click", button)

    def press_close_button(self, window):
        """Does what a window manager does when the cross in a window's corner is clicked."""
        x11 = ctypes.CDLL("libX11.so.6")
        x11.XOpenDisplay.restype = ctypes.c_void_p
        x11.XInternAtom.restype = ctypes.c_ulong
        display = ctypes.c_void_p(x11.XOpenDisplay(self.display.encode()))
        event = _ClientMessage(
            type=33,
            window=int(window),
            format=32,
            message_type=x11.XInternAtom(display, b"WM_PROTOCOLS", 0),
        )
        event.data[0] = x11.XInternAtom(display, b"WM_DELETE_WINDOW", 0)
        x11.XSendEvent(
            display, ctypes.c_ulong(int(window)), 0, ctypes.c_long(0), ctypes.byref(event)
        )
        x11.XCloseDisplay(display)


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
