"""Functions in machine code return the numbers of plain ones, and keep their code in files."""

import importlib
import sys

import pytest

from sdc_common.machine_code import compiled, numba_module

SOURCE = """
def step(x):
    return x + 3.0

def outer(x):
    return 2.0 * step(x)
"""


def loaded():
    """Return the compiled function of the module as a new process gets it."""
    sys.modules.pop("compiled_pair", None)
    importlib.invalidate_caches()
    pair = importlib.import_module("compiled_pair")
    return compiled(pair.outer, pair.step)


@pytest.fixture
def module(tmp_path, monkeypatch):
    pytest.importorskip("numba")
    monkeypatch.syspath_prepend(tmp_path)
    path = tmp_path / "compiled_pair.py"
    path.write_text(SOURCE)
    return path


def test_later_processes_read_the_machine_code_from_files(module):
    first, second = loaded(), loaded()
    assert first(1.0) == second(1.0) == 8.0
    assert sum(first.stats.cache_hits.values()) == 0
    assert sum(second.stats.cache_hits.values()) == 1
    assert {path.suffix for path in module.parent.glob("__pycache__/*.nb?")} == {".nbi", ".nbc"}


def test_function_without_a_folder_for_the_cache_is_compiled_in_each_process(module, monkeypatch):
    def no_folder(*_):
        raise RuntimeError("no locator available")

    monkeypatch.setattr("numba.core.caching.FunctionCache", no_folder)
    monkeypatch.setattr("numba.core.dispatcher.FunctionCache", no_folder)
    assert loaded()(1.0) == 8.0


def test_numba_that_cannot_be_imported_is_named_once(monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", None)
    numba_module.cache_clear()
    with pytest.warns(RuntimeWarning, match="40 times slower without Numba .*; run ") as caught:
        assert numba_module() is numba_module() is None
    assert len(caught) == 1
    numba_module.cache_clear()
