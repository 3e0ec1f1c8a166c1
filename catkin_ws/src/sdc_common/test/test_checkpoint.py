import os

import pytest

from sdc_common.ros import checkpoint
from sdc_common.ros.checkpoint import Checkpoint
from sdc_common.ros.supervisor import STATE_FOLDER_VARIABLE


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(STATE_FOLDER_VARIABLE, str(tmp_path))
    return tmp_path


def test_nothing_is_saved_without_a_folder(monkeypatch):
    monkeypatch.delenv(STATE_FOLDER_VARIABLE, raising=False)
    state = Checkpoint()
    assert not state.save({"a": 1})
    assert state.load() is None
    assert state.failure is None


def test_next_process_loads_the_last_state_bit_for_bit(folder):
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


def test_damaged_state_falls_back_to_the_one_before(folder):
    state = Checkpoint()
    state.save({"number": 1})
    state.save({"number": 2})
    file = folder / "checkpoint"
    file.write_bytes(file.read_bytes()[:-3])
    assert Checkpoint().load() == {"number": 1}


def test_file_size_is_bounded(folder, monkeypatch):
    monkeypatch.setattr(checkpoint, "_MAX_SIZE_BYTES", 1000)
    state = Checkpoint()
    for number in range(500):
        assert state.save({"number": number})
        assert sum(path.stat().st_size for path in folder.iterdir()) < 1100
        assert Checkpoint().load() == {"number": number}


def test_full_disk_is_reported_and_raises_nothing(folder):
    os.symlink("/dev/full", folder / "checkpoint")
    state = Checkpoint()
    assert not state.save({"a": 1})
    assert "No space left" in str(state.failure)
    assert not state.save({"a": 2})
