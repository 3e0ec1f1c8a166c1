"""Functions of numbers in machine code, where Numba is installed (Debian: python3-numba).

The numbers are those of the plain functions, bit for bit: without its fast-math options Numba
computes each operation as Python does. The first use of a function takes about a second; the later
ones, in any process, read the machine code from a file.
"""

from __future__ import annotations

import warnings
from functools import lru_cache
from types import ModuleType
from typing import Any, Callable


@lru_cache(maxsize=1)
def numba_module() -> ModuleType | None:
    """Return the module numba, or None if it is not installed."""
    try:
        with warnings.catch_warnings():
            # Of Debian's llvmlite, about importlib.
            warnings.simplefilter("ignore", DeprecationWarning)
            # It takes half a second.
            import numba
    except ImportError:
        return None
    return numba


@lru_cache(maxsize=None)
def compiled(function: Callable[..., Any], *callees: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function in machine code, or the function itself if Numba is not installed.

    Args:
        function: a function of numbers, tuples and arrays
        callees: the functions that it calls, directly or not, which stay plain functions in Python
    """
    numba = numba_module()
    if numba is None:
        return function
    for callee in callees:
        _make_callable(callee)
    from sdc_common.machine_code_cache import use_cache

    dispatcher = numba.njit(function, nogil=True)
    use_cache(dispatcher, *callees)
    return dispatcher


@lru_cache(maxsize=None)
def _make_callable(function: Callable[..., Any]) -> None:
    """Let compiled functions call a function that stays a plain one in Python."""
    from numba.extending import register_jitable

    register_jitable(function)
