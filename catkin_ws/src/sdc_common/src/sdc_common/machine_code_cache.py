"""Machine code in files, so that a function is compiled once and not in each process.

Numba's own cache notices a change in the file of a function, but not one in a function that it
calls. Here, the name of the folder contains a hash of the packages concerned.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import pickle
import shutil
import sys
from functools import lru_cache
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator

import numba
import numpy as np
from numba.core.caching import FunctionCache

# A change in a package makes a new folder; the latest are kept.
_KEPT_FOLDERS = 24
# Of a file that was not written to its end, or is of another version.
_UNREADABLE = (OSError, EOFError, pickle.UnpicklingError, ValueError, TypeError, LookupError)


def use_cache(dispatcher: Any, *callees: Callable[..., Any]) -> None:
    """Let a function of Numba read and write its machine code in the user's cache folder.

    Without a folder that can be written, it is compiled in each process.

    Args:
        dispatcher: what numba.njit returns
        callees: the functions that it calls, directly or not
    """
    function = dispatcher.py_func
    packages = {of.__module__.partition(".")[0] for of in (function, *callees)}
    folder = _folder(frozenset(packages))
    if folder is not None:
        dispatcher._cache = _cache(function, folder)


def _cache(function: Callable[..., Any], folder: Path) -> _LockedCache:
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(folder)
    try:
        return _LockedCache(function)
    finally:
        numba.config.CACHE_DIR = before


class _LockedCache(FunctionCache):
    """A cache that several processes may write, and whose faults cost time only.

    Without the lock, two processes may give the same name to the code of two signatures.
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled function for a signature, or None."""
        with contextlib.suppress(*_UNREADABLE):
            return super().load_overload(sig, target_context)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save the compiled function for a signature."""
        with contextlib.suppress(*_UNREADABLE), _locked(Path(self.cache_path).parent):
            super().save_overload(sig, data)


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[None]:
    with open(folder / "lock", "w", encoding="ascii") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


@lru_cache(maxsize=None)
def _folder(packages: frozenset) -> Path | None:
    """Return the folder for functions of these packages; None if it cannot be written."""
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    above = Path(cache, "sdc_machine_code")
    folder = above / _fingerprint(packages)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
        with _locked(folder):
            pass
    except OSError:
        return None
    _remove_all_but_latest(above)
    return folder


def _fingerprint(packages: Iterable[str]) -> str:
    """Return a hash of the source files of packages, and of the versions of what compiles them."""
    found = hashlib.sha256(f"{sys.version} {numba.__version__} {np.__version__}".encode())
    for package in sorted(packages):
        module = sys.modules[package]
        # Catkin makes a package of two folders.
        folders = getattr(module, "__path__", None)
        paths = [path for folder in folders or () for path in sorted(Path(folder).rglob("*.py"))]
        for path in paths if folders else [Path(str(module.__file__))]:
            found.update(f"{path}\0".encode())
            found.update(hashlib.sha256(path.read_bytes()).digest())
    return found.hexdigest()[:32]


def _remove_all_but_latest(above: Path) -> None:
    ages = []
    for path in above.iterdir():
        with contextlib.suppress(OSError):
            ages.append((path.stat().st_mtime, path))
    for _, path in sorted(ages)[:-_KEPT_FOLDERS]:
        shutil.rmtree(path, ignore_errors=True)
