"""A display where there is none, with a keyboard and a camera: for tests of windows, and for pictures of them."""

from __future__ import annotations

import os
import subprocess

import cv2
import numpy as np


class VirtualDisplay:
    """An Xvfb on the next free display number, from `with` to its end. Programs started with `environment` open their windows
    there. Raises FileNotFoundError where Xvfb is not installed, and OSError when it does not start."""

    def __init__(self, width: int = 1280, height: int = 900):
        self._size = width, height
        self._server = None

    def __enter__(self):
        width, height = self._size
        read, write = os.pipe()
        try:
            self._server = subprocess.Popen(
                [
                    "Xvfb",
                    "-displayfd",
                    str(write),
                    "-screen",
                    "0",
                    f"{width}x{height}x24",
                    "-nolisten",
                    "tcp",
                    "-noreset",
                ],
                pass_fds=[write],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
        finally:
            os.close(write)
        with os.fdopen(read) as numbers:
            number = numbers.readline().strip()
        if not number:
            self._server.wait()
            raise OSError(f"Xvfb ended with {self._server.returncode}")
        self.environment = dict(os.environ, DISPLAY=f":{number}", LIBGL_ALWAYS_SOFTWARE="1")
        return self

    def __exit__(self, *_):
        self._server.terminate()
        self._server.wait()

    def windows(self, title: str):
        """Numbers of the visible windows whose title contains `title`."""
        # By class, which every window has: searched by name, windows are missed whose name is UTF-8.
        windows = self._xdotool("search", "--onlyvisible", "--class", ".").stdout.split()
        return [
            window for window in windows if title in self._xdotool("getwindowname", window).stdout
        ]

    def focus(self, title: str) -> None:
        """Give the keyboard to the window with this title."""
        self._xdotool("windowfocus", "--sync", self.windows(title)[0], check=True)

    def key_down(self, key: str) -> None:
        """Hold a key; names as in X: w, Up, space, Tab, BackSpace, F1, Escape."""
        self._xdotool("keydown", key, check=True)

    def key_up(self, key: str) -> None:
        """Let a key go."""
        self._xdotool("keyup", key, check=True)

    def press(self, key: str) -> None:
        """Press a key and let it go."""
        self._xdotool("key", key, check=True)

    def move(self, x: int, y: int) -> None:
        """Put the pointer on a pixel of the screen."""
        self._xdotool("mousemove", str(x), str(y), check=True)

    def click(self, x: int, y: int) -> None:
        """Click the left button on a pixel of the screen."""
        self._xdotool("mousemove", str(x), str(y), "click", "1", check=True)

    def drag(self, x: int, y: int, to_x: int, to_y: int) -> None:
        """Drag with the left button from one pixel of the screen to another."""
        self._xdotool(
            "mousemove",
            str(x),
            str(y),
            "mousedown",
            "1",
            "mousemove",
            str((x + to_x) // 2),
            str((y + to_y) // 2),
            "mousemove",
            str(to_x),
            str(to_y),
            "mouseup",
            "1",
            check=True,
        )

    def picture(self, window: str = "root") -> np.ndarray:
        """What a window shows, or the whole screen, as (H, W, 3) BGR uint8. Raises LookupError when the window is gone."""
        which = ["-root"] if window == "root" else ["-id", window]
        done = subprocess.run(
            ["xwd", "-silent", *which], env=self.environment, capture_output=True, check=False
        )
        if done.returncode:
            raise LookupError(
                f"no picture of the window {window}: {done.stderr.decode(errors='replace').strip()}"
            )
        dump = done.stdout
        header = np.frombuffer(dump, ">u4", 25)
        header_size, width, height, pixel_bytes, row_bytes, colours = header[
            [0, 4, 5, 11, 12, 19]
        ] // (1, 1, 1, 8, 1, 1)
        rows = np.frombuffer(
            dump, np.uint8, height * row_bytes, header_size + 12 * colours
        ).reshape(height, row_bytes)
        return rows[:, : width * pixel_bytes].reshape(height, width, pixel_bytes)[:, :, :3].copy()

    def save(self, path: str, window: str = "root") -> None:
        """Write the picture of a window, or of the whole screen, as PNG. Raises OSError when that fails, LookupError as `picture`."""
        os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
        if not cv2.imwrite(path, self.picture(window)):
            raise OSError(f"{path} could not be written")

    def _xdotool(self, *arguments, check=False):
        return subprocess.run(
            ["xdotool", *arguments],
            env=self.environment,
            capture_output=True,
            text=True,
            check=check,
            timeout=30,
        )
