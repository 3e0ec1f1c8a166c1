"""A student's workspace as the checks see it: its files, and the environment in which its programs run. Nothing is ever written there."""

from __future__ import annotations

import os
import re
import subprocess
from functools import cached_property
from pathlib import Path

from sdc_workshop.workspace import PACKAGE, PROJECT

_LIMIT_S = 60
_MD5 = re.compile(r'_md5sum = "([0-9a-f]{32})"')
# What a program of the student's gets from the caller's environment; the rest comes from the workspace.
_KEPT = ("HOME", "LANG", "LC_ALL", "USER", "TMPDIR")


class NotBuilt(Exception):
    """The workspace has no devel space, or one that does not work; the message says what to type."""


class Student:
    """The workspace in `folder`."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.src = folder / "src"

    def text(self, name: str) -> str | None:
        """A file below src, None when it is not there. What is not UTF-8 is replaced: Python and CMake will say what they think of it."""
        try:
            return (self.src / name).read_text(encoding="utf-8", errors="replace")
        except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
            return None

    @property
    def devel(self) -> Path:
        return self.folder / "devel"

    @property
    def library(self) -> Path:
        """Where the library of the car lies."""
        return self.src / PACKAGE / "src" / PACKAGE

    @property
    def built_python(self) -> Path:
        """Where the build puts the Python of the package: its messages."""
        for python in sorted(self.devel.glob("lib/python3*/dist-packages")):
            return python / PACKAGE
        return self.devel / "lib" / "python3" / "dist-packages" / PACKAGE

    def built_md5(self, message: str) -> str | None:
        """Fingerprint of a message's class as it was built last; None when there is no such class."""
        try:
            found = _MD5.search(
                (self.built_python / "msg" / f"_{message}.py").read_text(encoding="utf-8")
            )
        except OSError:
            return None
        return found[1] if found else None

    @cached_property
    def environment(self) -> dict:
        """Environment variables of a new terminal after `source devel/setup.bash`. Raises NotBuilt."""
        setup = self.devel / "setup.bash"
        if not setup.is_file():
            raise NotBuilt(f"there is no {setup}")
        plain = {name: os.environ[name] for name in _KEPT if name in os.environ}
        plain["PATH"] = "/usr/local/bin:/usr/bin:/bin"
        done = subprocess.run(
            ["bash", "-c", 'source "$1" >/dev/null && env -0', "bash", str(setup)],
            env=plain,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=_LIMIT_S,
            check=False,
        )
        if done.returncode != 0:
            raise NotBuilt(
                f"{setup} ended with {done.stderr.strip().splitlines()[-1:] or done.returncode}"
            )
        found = dict(line.split("=", 1) for line in done.stdout.split("\0") if "=" in line)
        known = [os.path.realpath(path) for path in found.get("ROS_PACKAGE_PATH", "").split(":")]
        if os.path.realpath(self.src) not in known:
            raise NotBuilt(
                f"{setup} was built for another folder: ROS_PACKAGE_PATH is {found.get('ROS_PACKAGE_PATH', '')}"
            )
        if f"{PROJECT / 'catkin_ws' / 'devel'}" in found.get("CMAKE_PREFIX_PATH", "").split(":"):
            raise NotBuilt(f"{setup} leans on the finished car of {PROJECT}")
        return found
