import os

import pytest

from sdc_sim.evaluation.event_log import EventLog


def test_event_log_resumes_the_same_drive_only(tmp_path):
    path = str(tmp_path / "events")
    first = EventLog(path, "a")
    first.append(["odometry", 1, 0.1 + 0.2])
    assert not first.resumed
    second = EventLog(path, "a")
    assert second.resumed
    second.append(["odometry", 2, 0.4])
    assert list(second.events()) == [["odometry", 1, 0.1 + 0.2], ["odometry", 2, 0.4]]
    other = EventLog(path, "b")
    assert not other.resumed
    assert list(other.events()) == []


def test_torn_last_event_is_dropped(tmp_path):
    path = tmp_path / "events"
    EventLog(str(path), "a").append(["command", 1])
    whole = path.stat().st_size
    EventLog(str(path), "a").append(["command", 2, 0.5])
    os.truncate(path, whole + 20)
    assert path.stat().st_size > whole
    again = EventLog(str(path), "a")
    again.append(["command", 3])
    assert list(again.events()) == [["command", 1], ["command", 3]]


def test_file_that_is_not_an_event_log_is_not_resumed(tmp_path):
    path = tmp_path / "events"
    path.write_bytes(b"\xff\x00 nonsense\n")
    event_log = EventLog(str(path), "a")
    assert not event_log.resumed
    assert list(event_log.events()) == []


def test_full_disk_loses_no_event(monkeypatch, tmp_path):
    event_log = EventLog(str(tmp_path / "events"), "a")
    event_log.append(["command", 1])
    write = os.write
    monkeypatch.setattr(os, "write", lambda file, line: write(file, line[:5]))
    event_log.append(["command", 2])
    monkeypatch.setattr(os, "write", write)
    event_log.append(["command", 3])
    assert list(event_log.events()) == [["command", 1], ["command", 2], ["command", 3]]
    assert "No space left" in str(event_log.failure)
    assert event_log.failure.filename == event_log.path
    assert list(EventLog(event_log.path, "a").events()) == [["command", 1]], (
        "the next log finds whole events on the disk"
    )


def test_removed_folder_loses_no_event(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    event_log = EventLog(str(folder / "events"), "a")
    event_log.append(["command", 1])
    os.remove(event_log.path)
    folder.rmdir()
    event_log.append(["command", 2])
    assert list(event_log.events()) == [["command", 1], ["command", 2]]
    event_log.remove()
    with pytest.raises(OSError, match="folder"):
        EventLog(str(folder / "events"), "a")
