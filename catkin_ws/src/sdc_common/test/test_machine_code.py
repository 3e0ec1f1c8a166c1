"""Machine code is kept in files, for as long as it is that of the source."""

import importlib
import os
import sys

import pytest

from sdc_common.machine_code import compiled

numba = pytest.importorskip("numba")
machine_code_cache = pytest.importorskip("sdc_common.machine_code_cache")

OUTER = "from {inner} import step\n\ndef outer(x):\n    return 2.0 * step(x)\n"
INNER = "LENGTH = 3.0\n\ndef step(x):\n    return x + LENGTH\n"
USER = "from {other} import LENGTH\n\ndef step(x):\n    return x + LENGTH\n"
IN_PACKAGE = ("compiled_pair.motion.outer", "compiled_pair.motion.inner", "compiled_pair.sizes")
IN_FILES = ("compiled_outer", "compiled_inner", "compiled_sizes")


@pytest.fixture
def pair(tmp_path, monkeypatch):
    """Return a function that loads modules as a new process does.

    It returns the compiled function `outer`, whose callee is in the second module.
    """
    cache = tmp_path / "cache"
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def write(module, text):
        path = tmp_path.joinpath(*module.split(".")).with_suffix(".py")
        if path.is_file() and path.read_text() == text:
            return
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        for folder in path.relative_to(tmp_path).parents[:-1]:
            (tmp_path / folder / "__init__.py").touch()

    def load(inner, other="", modules=IN_PACKAGE):
        write(modules[0], OUTER.format(inner=modules[1]))
        write(modules[1], inner.format(other=modules[2]))
        write(modules[2], other)
        forget()
        outer = importlib.import_module(modules[0])
        return compiled(outer.outer, outer.step)

    def forget():
        for name in [name for name in sys.modules if name.startswith("compiled_")]:
            del sys.modules[name]
        importlib.invalidate_caches()
        machine_code_cache._folder.cache_clear()

    yield load
    forget()


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


def test_machine_code_of_plain_files_is_read_until_the_callee_changes(pair):
    first = pair(INNER, modules=IN_FILES)
    assert (first(1.0), was_read(first)) == (8.0, False)
    second = pair(INNER, modules=IN_FILES)
    assert (second(1.0), was_read(second)) == (8.0, True)
    changed = pair(INNER.replace("3.0", "5.0"), modules=IN_FILES)
    assert (changed(1.0), was_read(changed)) == (12.0, False)


def test_machine_code_is_not_read_after_a_change_in_any_file_of_the_package(pair):
    first, changed = (pair(USER, f"LENGTH = {length}\n") for length in (3.0, 5.0))
    assert (first(1.0), changed(1.0)) == (8.0, 12.0)
    assert not was_read(changed)


def test_functions_of_others_keep_their_cache_folder(pair):
    folder = numba.config.CACHE_DIR
    pair(INNER)
    assert folder == numba.config.CACHE_DIR


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


def test_what_is_no_folder_is_left_in_the_cache(pair, tmp_path):
    """A folder may also disappear while the ages of the folders are read."""
    folders = tmp_path / "cache" / "sdc_machine_code"
    for number in range(40):
        (folders / str(number)).mkdir(parents=True)
    (folders / "note").write_text("a file, and no folder")
    os.utime(folders / "note", (0, 0))
    (folders / "lost").symlink_to(tmp_path / "nothing")
    function = pair(INNER)
    assert function(1.0) == 8.0
    assert (folders / "note").is_file()
    assert (folders / "lost").is_symlink()
