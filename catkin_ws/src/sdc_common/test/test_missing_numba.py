"""Machine code where Numba is missing."""

import sys

import pytest

from sdc_common.machine_code import numba_module


def test_numba_that_cannot_be_imported_is_named_once(monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", None)
    numba_module.cache_clear()
    with pytest.warns(RuntimeWarning, match="40 times slower without Numba .*; run ") as caught:
        assert numba_module() is numba_module() is None
    assert len(caught) == 1
    numba_module.cache_clear()
