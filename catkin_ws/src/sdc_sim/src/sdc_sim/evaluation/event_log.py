"""The events of a drive on disk, from which a killed referee resumes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

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
        self._drive_id = drive_id
        self._unwritten: list = []
        self._log = RecordLog(path)
        self.resumed = next(self._log.records(), None) == [drive_id]
        if not self.resumed:
            self.clear()
        if self._log.failure is not None:
            raise self._log.failure

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

    def remove(self) -> None:
        """Delete the file: the drive is reported."""
        self._log.remove()
