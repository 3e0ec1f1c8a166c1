"""A screen that nobody sees, with a real mouse and keyboard: Xvfb and xdotool, for the tests of the window."""
from __future__ import annotations

import ctypes
import os
import subprocess
import time

WINDOW_SECONDS = 30.0  # at most, from a node's start to its window


class VirtualScreen:
    """An X server of its own on a free display. Use it in a `with`, or call stop()."""

    def __init__(self, width=1200, height=760):
        reader, writer = os.pipe()
        self._server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(writer), "-screen", "0", f"{width}x{height}x24", "-nolisten", "tcp"],
            pass_fds=[writer], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(writer)
        with os.fdopen(reader) as pipe:
            number = pipe.readline().strip()  # the server writes it once it takes clients
        if not number:
            raise RuntimeError("Xvfb did not start: apt-get install xvfb")
        self.display = f":{number}"
        self.environment = dict(os.environ, DISPLAY=self.display, QT_QPA_PLATFORM="xcb")
        self.environment.pop("WAYLAND_DISPLAY", None)

    def __enter__(self):
        return self

    def __exit__(self, *_error):
        self.stop()

    def stop(self):
        """Ends the X server."""
        self._server.terminate()
        self._server.wait()

    def xdotool(self, *arguments):
        """Runs xdotool, which moves the screen's mouse and presses its keys; returns what it prints."""
        return subprocess.run(["xdotool", *map(str, arguments)], env=self.environment, check=True, timeout=60,
                              stdout=subprocess.PIPE, text=True).stdout.strip()

    def find_window(self, name):
        """The id of the window with this name, as soon as it is shown; gives it the keyboard."""
        end = time.monotonic() + WINDOW_SECONDS
        while True:
            search = subprocess.run(["xdotool", "search", "--onlyvisible", "--name", name], env=self.environment,
                                    check=False, timeout=60, stdout=subprocess.PIPE, text=True)
            if search.stdout.strip():
                break
            if time.monotonic() > end:
                raise AssertionError(f"no window called {name!r} was shown within {WINDOW_SECONDS} s")
            time.sleep(0.1)
        window = search.stdout.split()[0]
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
        event = _ClientMessage(type=33, window=int(window), format=32,
                               message_type=x11.XInternAtom(display, b"WM_PROTOCOLS", 0))
        event.data[0] = x11.XInternAtom(display, b"WM_DELETE_WINDOW", 0)
        x11.XSendEvent(display, ctypes.c_ulong(int(window)), 0, ctypes.c_long(0), ctypes.byref(event))
        x11.XCloseDisplay(display)


class _ClientMessage(ctypes.Structure):
    """XClientMessageEvent of Xlib.h, padded to the size of an XEvent."""

    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int),
                ("display", ctypes.c_void_p), ("window", ctypes.c_ulong), ("message_type", ctypes.c_ulong),
                ("format", ctypes.c_int), ("data", ctypes.c_long * 5), ("padding", ctypes.c_long * 24)]
