"""A virtual display with a keyboard, a mouse and pictures of its windows."""

from __future__ import annotations

import os
import shutil
import subprocess

import numpy as np
from pyvirtualdisplay import Display
from pyvirtualdisplay.abstractdisplay import XStartError

# xwd reads a window and those in it one by one; one that closes or moves meanwhile ends it.
_READINGS = 20


class VirtualDisplay:
    """An Xvfb server, from `with` to the end of the block, which xdotool and xwd control.

    Attributes:
        environment: environment variables of programs that open their windows there
    """

    def __init__(self, width: int = 1280, height: int = 900):
        """Describe a display.

        Args:
            width: width of the screen [px]
            height: height of the screen [px]
        """
        self._size = width, height

    def __enter__(self) -> VirtualDisplay:
        """Start the server.

        Raises:
            FileNotFoundError: Xvfb is not installed
            OSError: Xvfb does not start
        """
        if shutil.which("Xvfb") is None:
            raise FileNotFoundError("Xvfb is not installed; run: apt-get install xvfb")
        self._display = Display(
            backend="xvfb", size=self._size, extra_args=["-noreset"], manage_global_env=False
        )
        try:
            self._display.start()
        except XStartError as error:
            raise OSError(str(error)) from error
        self.environment = dict(
            os.environ, DISPLAY=self._display.new_display_var, LIBGL_ALWAYS_SOFTWARE="1"
        )
        return self

    def __exit__(self, *_: object) -> None:
        """Stop the server."""
        self._display.stop()

    def windows(self, title: str) -> list[str]:
        """Return the numbers of the visible windows whose title contains `title`."""
        # Every window has a class. A search by name misses windows whose name is UTF-8.
        windows = self.xdotool("search", "--onlyvisible", "--class", ".", check=False).split()
        name = "getwindowname"
        return [window for window in windows if title in self.xdotool(name, window, check=False)]

    def focus(self, title: str) -> None:
        """Give the keyboard focus to the window with this title."""
        self.xdotool("windowfocus", "--sync", self.windows(title)[0])

    def key_down(self, key: str) -> None:
        """Press a key and hold it; names as in X: w, Up, space, Tab, BackSpace, F1, Escape."""
        self.xdotool("keydown", key)

    def key_up(self, key: str) -> None:
        """Release a key."""
        self.xdotool("keyup", key)

    def press(self, key: str) -> None:
        """Press and release a key."""
        self.xdotool("key", key)

    def move(self, x: int, y: int) -> None:
        """Move the pointer to a pixel of the screen."""
        self.xdotool("mousemove", x, y)

    def click(self, x: int, y: int, button: int = 1) -> None:
        """Click on a pixel of the screen; buttons 4 and 5 are the wheel up and down."""
        self.xdotool("mousemove", x, y, "click", button)

    def drag(self, x: int, y: int, to_x: int, to_y: int) -> None:
        """Drag with the left button from one pixel of the screen to another."""
        middle = (x + to_x) // 2, (y + to_y) // 2
        self.xdotool("mousemove", x, y, "mousedown", 1, "mousemove", *middle)
        self.xdotool("mousemove", to_x, to_y, "mouseup", 1)

    def picture(self, window: str = "root") -> np.ndarray:
        """Return the picture of a window, or of the whole screen, as (H, W, 3) BGR uint8.

        Raises:
            LookupError: the window does not exist any more
        """
        which = ["-root"] if window == "root" else ["-id", window]
        for _ in range(_READINGS):
            done = subprocess.run(
                ["xwd", "-silent", *which], env=self.environment, capture_output=True, check=False
            )
            if done.returncode == 0:
                return self._decoded(done.stdout)
        raise LookupError(
            f"no picture of the window {window}: {done.stderr.decode(errors='replace').strip()}"
        )

    @staticmethod
    def _decoded(dump: bytes) -> np.ndarray:
        """Return the picture in a file of xwd, as (H, W, 3) BGR uint8."""
        header = np.frombuffer(dump, ">u4", 25)
        header_size, width, height, pixel_bytes, row_bytes, colours = header[
            [0, 4, 5, 11, 12, 19]
        ] // (1, 1, 1, 8, 1, 1)
        rows = np.frombuffer(
            dump, np.uint8, height * row_bytes, header_size + 12 * colours
        ).reshape(height, row_bytes)
        return rows[:, : width * pixel_bytes].reshape(height, width, pixel_bytes)[:, :, :3].copy()

    def xdotool(self, *arguments: object, check: bool = True) -> str:
        """Run xdotool, which moves the pointer and presses keys, and return what it prints."""
        return subprocess.run(
            ["xdotool", *map(str, arguments)],
            env=self.environment,
            stdout=subprocess.PIPE,
            text=True,
            check=check,
            timeout=30,
        ).stdout
