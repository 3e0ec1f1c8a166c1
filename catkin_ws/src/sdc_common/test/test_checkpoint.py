import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_common.ros.checkpoint import FOLDER, Checkpoint


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER, str(tmp_path))
    return tmp_path


def test_without_a_folder_nothing_is_kept(monkeypatch):
    monkeypatch.delenv(FOLDER, raising=False)
    state = Checkpoint()
    assert not state.save({"a": 1})
    assert state.load() is None
    assert state.problem is None


def test_the_next_process_finds_the_last_state_bit_for_bit(folder):
    state = Checkpoint()
    assert state.load() is None
    for number in range(5):
        assert state.save(
            {"number": number, "x_m": 0.1 * number, "long": "x" * (100 - 20 * number)}
        )
    after = Checkpoint()
    assert after.load() == {"number": 4, "x_m": 0.4, "long": "x" * 20}
    assert after.save({"number": 5})
    assert Checkpoint().load() == {"number": 5}


@given(cut=st.integers(0, 60), flipped=st.integers(0, 40))
def test_a_write_that_was_cut_short_costs_one_state(tmp_path_factory, cut, flipped):
    folder = tmp_path_factory.mktemp("kept")
    os.environ[FOLDER] = str(folder)
    try:
        state = Checkpoint()
        state.save({"number": 1, "padding": "y" * 50})
        state.save({"number": 2, "padding": "z" * 50})
        newest = folder / "state0"
        content = newest.read_bytes()
        broken = bytearray(content[:cut])
        if flipped < len(broken):
            broken[flipped] ^= 0x55
        newest.write_bytes(bytes(broken))
        assert Checkpoint().load()["number"] == 1
    finally:
        del os.environ[FOLDER]


def test_a_disk_that_is_full_is_told_once_and_stops_nothing(folder):
    for name in ("state0", "state1"):
        os.symlink("/dev/full", folder / name)
    state = Checkpoint()
    assert not state.save({"a": 1})
    assert "No space left" in state.problem
    assert not state.save({"a": 2})
