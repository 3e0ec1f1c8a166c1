"""Temporary folders; a command removes those that killed ones have left."""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import tempfile
from pathlib import Path
from typing import Iterator

_LOCK = "lock"


@contextlib.contextmanager
def temporary_folder(prefix: str) -> Iterator[Path]:
    """Yield a new folder with this prefix, in which the process locks a file while it lives."""
    for left in Path(tempfile.gettempdir()).glob(f"{prefix}*"):
        with contextlib.suppress(OSError):
            if left.lstat().st_uid == os.geteuid():
                with open(left / _LOCK, encoding="ascii") as file:
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    shutil.rmtree(left)
    with tempfile.TemporaryDirectory(prefix=prefix) as name, open(f"{name}/{_LOCK}", "w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield Path(name)
