"""A student's workspace as the checks see it: its files and its environment. It is read only."""

from __future__ import annotations

import os
import re
from functools import cached_property
from pathlib import Path
from typing import Callable

from sdc_workshop.exam.process import Program
from sdc_workshop.student_file import read
from sdc_workshop.workspace import PACKAGE, PROJECT, WORLD, WORLD_SETUP

_TIMEOUT_S = 60
_MAX_BYTES = 1_000_000
_MD5 = re.compile(r'_md5sum = "([0-9a-f]{32})"')
# The variables that a student's program inherits; all others come from the workspace.
_KEPT = ("HOME", "LANG", "LC_ALL", "USER", "TMPDIR")


class NotBuilt(Exception):
    """The workspace has no usable devel space; the message names the reason."""


class Student:
    """The workspace in a folder; `run` starts a command with its environment variables."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.src = folder / "src"
        self.run: Callable[[list, dict], Program] = Program

    def text(self, name: str) -> str | None:
        """Return the text of a file below src, or None without such a file.

        Raises:
            FileError: Python or ROS cannot read it
        """
        return read(self.src, name) if (self.src / name).is_file() else None

    @property
    def devel(self) -> Path:
        """The devel space."""
        return self.folder / "devel"

    def built_python(self, package: str = PACKAGE) -> Path:
        """Return the folder of a package's generated Python: its messages."""
        found = sorted(self.devel.glob("lib/python3*/dist-packages"))
        return (found or [self.devel / "lib/python3/dist-packages"])[0] / package

    def built_md5(self, message: str) -> str | None:
        """Return the md5 sum of a message's generated class, or None without such a class."""
        path = self.built_python() / "msg" / f"_{message}.py"
        try:
            # The build may have made anything, such as a link to an endless device.
            if not path.is_file() or path.stat().st_size > _MAX_BYTES:
                return None
            found = _MD5.search(path.read_text(encoding="utf-8", errors="replace"))
        except OSError:
            return None
        return found[1] if found else None

    @cached_property
    def environment(self) -> dict:
        """Environment variables of a new terminal after `source devel/setup.bash`.

        Raises:
            NotBuilt: there is no devel space, or it does not overlay the world's workspace
        """
        setup = self.devel / "setup.bash"
        if not setup.is_file():
            raise NotBuilt(f"there is no {setup}")
        plain = {name: os.environ[name] for name in _KEPT if name in os.environ}
        plain["PATH"] = "/usr/local/bin:/usr/bin:/bin"
        script = 'source "$1" >/dev/null && printf "\\0" && env -0'
        with self.run(["bash", "-c", script, "bash", str(setup)], plain) as program:
            status, (errors, *lines) = program.wait(_TIMEOUT_S), program.output.split("\0")
        if status is None:
            raise NotBuilt(f"{setup} does not end")
        if status != 0:
            raise NotBuilt(f"{setup} ended with {errors.strip().splitlines()[-1:] or status}")
        found = dict(line.split("=", 1) for line in lines if "=" in line)
        sources = _real_paths(found.get("ROS_PACKAGE_PATH", ""))
        overlaid = _real_paths(found.get("CMAKE_PREFIX_PATH", ""))
        if os.path.realpath(self.src) not in sources:
            raise NotBuilt(
                f"{setup} was built for another folder: "
                f"ROS_PACKAGE_PATH is {found.get('ROS_PACKAGE_PATH', '')}"
            )
        if os.path.realpath(PROJECT / "catkin_ws" / "devel") in overlaid:
            raise NotBuilt(
                f"{setup} overlays the finished car: the terminal in which it was built had "
                f"sourced {PROJECT}/catkin_ws/devel/setup.bash"
            )
        if os.path.realpath(WORLD / "devel") not in overlaid:
            raise NotBuilt(
                f"{setup} does not overlay the world: the terminal in which it was built had "
                f"not sourced {WORLD_SETUP}"
            )
        return found


def _real_paths(paths: str) -> list:
    return [os.path.realpath(path) for path in paths.split(":")]
