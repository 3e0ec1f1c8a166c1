"""Functions of numbers in machine code, where Numba is installed (Debian: python3-numba).

The numbers are those of the plain functions, bit for bit: without its fast-math options Numba
computes each operation as Python does. The first use of a function takes about a second; the later
ones, in any process, read the machine code from Numba's cache next to the source file. Numba does
not notice a change in a function that the compiled one calls: the build of the workspace deletes
the cache.
"""

from __future__ import annotations

import warnings
from functools import lru_cache
from types import ModuleType
from typing import Any, Callable

from sdc_common.configuration import how_to_install


@lru_cache(maxsize=1)
def numba_module() -> ModuleType | None:
    """Return the module numba, or None with a warning if it cannot be imported."""
    try:
        # The import takes half a second.
        import numba
    except ImportError as error:
        warnings.warn(
            f"simulations run about 40 times slower without Numba ({error}); "
            f"{how_to_install('fast')}; Debian's accepts no new NumPy of a virtual environment, "
            "such as one from 1.25",
            RuntimeWarning,
            stacklevel=2,
        )
        return None
    return numba


@lru_cache(maxsize=None)
def compiled(function: Callable[..., Any], *callees: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function of numbers, tuples and arrays in machine code, or itself without Numba.

    The callees, which it calls directly or not, stay plain functions in Python.
    """
    numba = numba_module()
    if numba is None:
        return function
    for callee in callees:
        numba.extending.register_jitable(callee)
    try:
        return numba.njit(function, nogil=True, cache=True)
    except RuntimeError:  # no folder for the cache can be written
        return numba.njit(function, nogil=True)
