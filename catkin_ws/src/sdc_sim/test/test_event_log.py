import os

import pytest

from sdc_sim.evaluation.event_log import EventLog


def test_goes_on_with_the_same_drive_only(tmp_path):
    path = str(tmp_path / "journal")
    first = EventLog(path, "a")
    first.write(["odometry", 1, 0.1 + 0.2])
    assert not first.resumed
    second = EventLog(path, "a")
    assert second.resumed
    second.write(["odometry", 2, 0.4])
    assert list(second.events()) == [["odometry", 1, 0.1 + 0.2], ["odometry", 2, 0.4]]
    other = EventLog(path, "b")
    assert not other.resumed
    assert list(other.events()) == []


def test_a_torn_line_is_forgotten(tmp_path):
    path = tmp_path / "journal"
    EventLog(str(path), "a").write(["command", 1])
    with open(path, "ab") as file:
        file.write(b'["command", 2, 0.')
    again = EventLog(str(path), "a")
    again.write(["command", 3])
    assert list(again.events()) == [["command", 1], ["command", 3]]


def test_what_is_no_journal_is_no_drive(tmp_path):
    path = tmp_path / "journal"
    path.write_bytes(b"\xff\x00 nonsense\n")
    assert not EventLog(str(path), "a").resumed


def test_a_full_disk_loses_nothing(monkeypatch, tmp_path):
    journal = EventLog(str(tmp_path / "journal"), "a")
    journal.write(["command", 1])
    write = os.write
    monkeypatch.setattr(os, "write", lambda file, line: write(file, line[:5]))
    journal.write(["command", 2])
    monkeypatch.setattr(os, "write", write)
    journal.write(["command", 3])
    assert list(journal.events()) == [["command", 1], ["command", 2], ["command", 3]]
    assert "No space left" in str(journal.failure)
    assert list(EventLog(journal.path, "a").events()) == [["command", 1]], (
        "what another one finds on the disk is whole"
    )


def test_a_folder_that_vanishes_loses_nothing(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    journal = EventLog(str(folder / "journal"), "a")
    journal.write(["command", 1])
    os.remove(journal.path)
    folder.rmdir()
    journal.write(["command", 2])
    assert list(journal.events()) == [["command", 1], ["command", 2]]
    journal.remove()
    with pytest.raises(OSError, match="folder"):
        EventLog(str(folder / "journal"), "a")
