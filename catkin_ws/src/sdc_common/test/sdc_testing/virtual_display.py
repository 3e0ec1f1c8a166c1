"""A virtual display with a keyboard, a mouse and pictures of its windows."""

from __future__ import annotations

import re
import shutil
import subprocess

import numpy as np
from PIL import ImageGrab
from pyvirtualdisplay import Display
from pyvirtualdisplay.abstractdisplay import XStartError


class VirtualDisplay(Display):
    """An Xvfb server, from `with` to the end of the block, which xdotool controls.

    Attributes:
        environment: environment variables of programs that open their windows there
    """

    def __init__(self, width: int = 1280, height: int = 900):
        """Describe a display.

        Args:
            width: width of the screen [px]
            height: height of the screen [px]

        Raises:
            FileNotFoundError: Xvfb is not installed
        """
        if shutil.which("Xvfb") is None:
            raise FileNotFoundError("Xvfb is not installed; run: apt-get install xvfb")
        super().__init__(
            "xvfb", size=(width, height), extra_args=["-noreset"], manage_global_env=False
        )

    def start(self) -> VirtualDisplay:
        """Start the server; raise OSError if it does not start."""
        try:
            super().start()
        except XStartError as error:
            raise OSError(str(error)) from error
        self.environment = {**self.env(), "LIBGL_ALWAYS_SOFTWARE": "1"}
        return self

    def windows(self, title: str) -> list[str]:
        """Return the numbers of the visible windows whose title contains `title`."""
        # Every window has a class. A search by name misses windows whose name is UTF-8.
        windows = self.xdotool("search", "--onlyvisible", "--class", ".", check=False).split()
        name = "getwindowname"
        return [window for window in windows if title in self.xdotool(name, window, check=False)]

    def focus(self, title: str) -> None:
        """Give the keyboard focus to the window with this title."""
        self.xdotool("windowfocus", "--sync", self.windows(title)[0])

    def click(self, x: int, y: int, button: int = 1) -> None:
        """Click on a pixel of the screen; buttons 4 and 5 are the wheel up and down."""
        self.xdotool("mousemove", x, y, "click", button)

    def picture(self, window: str = "") -> np.ndarray:
        """Return the picture of a window, or of the whole screen, as (H, W, 3) BGR uint8.

        Raises:
            LookupError: the window does not exist any more
        """
        screen = np.array(ImageGrab.grab(xdisplay=self.environment["DISPLAY"]))[:, :, ::-1]
        if not window:
            return screen
        geometry = self.xdotool("getwindowgeometry", "--shell", window, check=False)
        value = {name: int(number) for name, number in re.findall(r"(\w+)=(\d+)", geometry)}
        x, y = value["X"], value["Y"]
        return screen[y : y + value["HEIGHT"], x : x + value["WIDTH"]]

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
