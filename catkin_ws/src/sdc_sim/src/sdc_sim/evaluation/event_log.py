"""The events of a drive on disk, from which a killed referee resumes."""

from __future__ import annotations

import contextlib
import fcntl
import itertools
import os
from collections.abc import Iterator
from typing import IO

from sdc_common.ros.record_log import RecordLog


class EventLog:
    """The events of one drive, lists of plain data, in the order in which they were received.

    The first record of the file is the drive's id. An event that cannot be written, as on a full
    disk, is kept in memory.
    """

    def __init__(self, path: str, drive_id: str):
        """Resume the log of this drive if the file holds one, else start an empty log.

        Args:
            path: the file; its folder must exist
            drive_id: identifies the drive; the log of another drive is discarded

        Raises:
            OSError: the file cannot be written
        """
        self.path = path
        self._lock: IO | None = None
        self._drive_id = drive_id
        self._unwritten: list = []
        self._log = RecordLog(path)
        self.resumed = next(self._log.records(), None) == [drive_id]
        if not self.resumed:
            self.clear()
        if self._log.failure is not None:
            raise self._log.failure

    @classmethod
    def locked(cls, path: str, drive_id: str) -> EventLog:
        """Return a log that no other process opens with this method or with `unfinished`.

        A log that another process uses, which draws the pages of an older drive, is replaced; that
        process keeps its file.

        Raises:
            OSError: the file cannot be written
        """
        lock = open(path, "ab")  # noqa: SIM115  open until `close`
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.close()
            os.remove(path)
            lock = open(path, "ab")  # noqa: SIM115
            fcntl.flock(lock, fcntl.LOCK_EX)
        event_log = cls(path, drive_id)
        event_log._lock = lock
        return event_log

    @classmethod
    def unfinished(cls, path: str) -> EventLog | None:
        """Return the log of a drive that has ended, locked; wait until no process uses it.

        Returns:
            None if the process that used the log has removed it

        Raises:
            OSError: the file does not exist or cannot be read
            ValueError: it is not an event log
        """
        with contextlib.ExitStack() as unless_returned:
            lock = unless_returned.enter_context(open(path, "rb+"))
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not _is_open(lock, path):
                return None
            head = next(RecordLog(path).records(), None)
            if not isinstance(head, list) or len(head) != 1:
                raise ValueError("is not an event log")
            event_log = cls(path, head[0])
            event_log._lock = lock
            unless_returned.pop_all()
        return event_log

    @property
    def failure(self) -> OSError | None:
        """Return why events are no longer written, or None."""
        return self._log.failure

    def clear(self) -> None:
        """Remove all events."""
        self._unwritten = []
        self._log.clear()
        self.append([self._drive_id])

    def append(self, event: list) -> None:
        """Append one event."""
        if not self._log.append(event):
            self._unwritten.append(event)

    def events(self) -> Iterator:
        """Yield all events, the oldest first, including those that could not be written."""
        return itertools.islice(itertools.chain(self._log.records(), self._unwritten), 1, None)

    @property
    def is_replaced(self) -> bool:
        """Return whether another drive has replaced the file of this locked log."""
        return self._lock is not None and not _is_open(self._lock, self.path)

    def close(self) -> None:
        """Close the file and let other processes use it."""
        self._log.close()
        if self._lock is not None:
            self._lock.close()

    def remove(self) -> None:
        """Delete the file, unless another drive has replaced it: the drive is reported."""
        if not self.is_replaced:
            self._log.remove()
        self.close()


def _is_open(file: IO, path: str) -> bool:
    """Return whether an open file is still the one at the path."""
    with contextlib.suppress(FileNotFoundError):
        return os.path.samestat(os.fstat(file.fileno()), os.stat(path))
    return False
