"""Machine code is kept in files, for as long as it is that of the source."""

import importlib
import os
import sys

import pytest

from sdc_common.machine_code import compiled

machine_code_cache = pytest.importorskip("sdc_common.machine_code_cache")

pytestmark = pytest.mark.slow(3)

OUTER = "from compiled_pair.inner import step\n\ndef outer(x):\n    return 2.0 * step(x)\n"
INNER = "LENGTH = 3.0\n\ndef step(x):\n    return x + LENGTH\n"


@pytest.fixture
def pair(tmp_path, monkeypatch):
    """Return a function that loads a package of two modules as a new process does.

    It returns the compiled function `outer`, whose callee is in the other module.
    """
    package, cache = tmp_path / "compiled_pair", tmp_path / "cache"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "outer.py").write_text(OUTER)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def load(inner):
        (package / "inner.py").write_text(inner)
        for name in [name for name in sys.modules if name.startswith("compiled_pair")]:
            del sys.modules[name]
        importlib.invalidate_caches()
        machine_code_cache._folder.cache_clear()
        outer = importlib.import_module("compiled_pair.outer")
        return compiled(outer.outer, outer.step)

    yield load
    machine_code_cache._folder.cache_clear()
    for name in [name for name in sys.modules if name.startswith("compiled_pair")]:
        del sys.modules[name]


def was_read(function):
    """Return whether the machine code of a function was read from a file."""
    return sum(function.stats.cache_hits.values()) > 0


def test_machine_code_is_read_until_a_callee_in_another_file_changes(pair, tmp_path):
    first = pair(INNER)
    assert (first(1.0), was_read(first)) == (8.0, False)
    second = pair(INNER)
    assert (second(1.0), was_read(second)) == (8.0, True)
    assert (second(1), was_read(second)) == (8.0, True)  # a second signature
    changed = pair(INNER.replace("3.0", "5.0"))
    assert (changed(1.0), was_read(changed)) == (12.0, False)
    back = pair(INNER)
    assert (back(1.0), back(1), was_read(back)) == (8.0, 8.0, True)
    assert sum(back.stats.cache_misses.values()) == 0

    for path in tmp_path.glob("cache/*/*/*/*.nbc"):
        os.truncate(path, path.stat().st_size // 2)
    damaged = pair(INNER)
    assert (damaged(1.0), was_read(damaged)) == (8.0, False)
    repaired = pair(INNER)
    assert (repaired(1.0), was_read(repaired)) == (8.0, True)


def test_cache_that_cannot_be_written_costs_time_only(pair, tmp_path):
    (tmp_path / "cache").write_text("a file, and no folder")
    for _ in range(2):
        function = pair(INNER)
        assert (function(1.0), was_read(function)) == (8.0, False)


def test_only_the_latest_folders_are_kept(pair, tmp_path):
    folders = tmp_path / "cache" / "sdc_machine_code"
    for number in range(40):
        (folders / str(number)).mkdir(parents=True)
        os.utime(folders / str(number), (number, number))
    function = pair(INNER)
    assert function(1.0) == 8.0
    assert len(list(folders.iterdir())) == machine_code_cache._KEPT_FOLDERS
    assert (folders / "39").is_dir()
    again = pair(INNER)
    assert (again(1.0), was_read(again)) == (8.0, True)
