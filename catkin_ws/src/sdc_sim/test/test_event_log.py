import fcntl
import os
import queue
import threading

import pytest

from sdc_common.ros.record_log import RecordLog
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


def test_log_that_another_drive_replaces_keeps_its_events_and_leaves_the_new_file(tmp_path):
    path = str(tmp_path / "events")
    old = EventLog.locked(path, "old")
    old.append(["command", 1])
    assert not old.is_replaced
    new = EventLog.locked(path, "new")
    assert (new.resumed, new.is_replaced, old.is_replaced) == (False, False, True)
    new.append(["command", 2])
    assert list(old.events()) == [["command", 1]]
    old.remove()
    assert list(new.events()) == [["command", 2]]
    assert not new.is_replaced
    new.remove()
    assert not os.path.exists(path)


def test_closed_log_is_free_for_the_next_process_of_its_drive(tmp_path):
    path = str(tmp_path / "events")
    first = EventLog.locked(path, "a")
    first.append(["command", 1])
    first.close()
    second = EventLog.locked(path, "a")
    assert (second.resumed, second.is_replaced) == (True, False)
    assert list(second.events()) == [["command", 1]]
    second.close()


def test_log_without_a_lock_is_never_replaced(tmp_path):
    event_log = EventLog(str(tmp_path / "events"), "a")
    os.remove(event_log.path)
    assert not event_log.is_replaced


def test_ended_drive_is_opened_under_its_own_name_and_locked(tmp_path):
    path = str(tmp_path / "events")
    driven = EventLog.locked(path, "a drive")
    driven.append(["command", 1])
    driven.close()
    ended = EventLog.unfinished(path)
    assert ended.resumed
    assert list(ended.events()) == [["command", 1]]
    assert not ended.is_replaced
    EventLog.locked(path, "another").close()
    assert ended.is_replaced
    ended.close()
    assert EventLog(path, "another").resumed


def test_ended_drive_waits_for_the_process_that_uses_it(tmp_path, monkeypatch):
    path = str(tmp_path / "events")
    used = EventLog.locked(path, "a")
    lock, is_opened, found = fcntl.flock, threading.Event(), queue.Queue()
    monkeypatch.setattr(fcntl, "flock", lambda *arguments: (is_opened.set(), lock(*arguments)))
    waiting = threading.Thread(target=lambda: found.put(EventLog.unfinished(path)))
    waiting.start()
    assert is_opened.wait(60.0)
    assert found.empty()
    used.remove()
    assert found.get(timeout=60.0) is None
    waiting.join()


def test_only_an_event_log_is_an_ended_drive(tmp_path):
    path = tmp_path / "events"
    with pytest.raises(FileNotFoundError):
        EventLog.unfinished(str(path))
    path.write_bytes(b"\xff\x00 nonsense\n")
    with pytest.raises(ValueError, match="^is not an event log$") as refusal:
        EventLog.unfinished(str(path))
    with open(path, "rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    assert refusal.tb is not None  # The lock is released although this refers to its variables.
    path.unlink()
    RecordLog(str(path)).append(["two", "words"])
    with pytest.raises(ValueError, match="^is not an event log$"):
        EventLog.unfinished(str(path))
