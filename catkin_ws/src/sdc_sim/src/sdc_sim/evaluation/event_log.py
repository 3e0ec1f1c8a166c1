"""What the referee heard, line by line in a file, so that a referee that was killed can go on where it stopped."""

from __future__ import annotations

import contextlib
import errno
import itertools
import json
import os

_encode = json.JSONEncoder(separators=(",", ":")).encode


class EventLog:
    """Events (lists of strings and numbers) in the order of hearing.

    Writing never raises: what a full disk does not take is kept in memory, and `failure` tells why.
    """

    def __init__(self, path: str, drive_id: str):
        """Go on with the journal of this drive where there is one, else begin anew. Raises OSError."""
        self.path = path
        self._drive_id = drive_id
        self.failure = None
        self._not_written = []
        self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        self.resumed = next(self._lines(), None) == [drive_id]
        if self.resumed:
            self._drop_torn_line()
        else:
            self.begin()

    def begin(self) -> None:
        """Forget everything and begin anew."""
        self._not_written = []
        with contextlib.suppress(OSError):
            os.ftruncate(self._file, 0)
        self.write([self._drive_id])

    def write(self, event: list) -> None:
        """Append one event."""
        if self.failure is None:
            line = _encode(event).encode() + b"\n"
            try:
                if os.write(self._file, line) == len(line):
                    return
                self.failure = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), self.path)
            except OSError as error:
                self.failure = OSError(error.errno, error.strerror, self.path)
        self._not_written.append(event)

    def events(self):
        """Yield all events so far, whether they could be written or not."""
        return itertools.islice(itertools.chain(self._lines(), self._not_written), 1, None)

    def _lines(self):
        # By the open file: its folder may have been moved or removed meanwhile.
        with open(self._file, "rb", closefd=False) as file:
            file.seek(0)
            for line in file:
                if not line.endswith(b"\n"):
                    return
                try:
                    yield json.loads(line)
                except ValueError:
                    return

    def _drop_torn_line(self) -> None:
        with open(self._file, "rb", closefd=False) as file:
            file.seek(0)
            whole = sum(len(line) for line in file if line.endswith(b"\n"))
        os.ftruncate(self._file, whole)

    def remove(self) -> None:
        """The drive is reported: nothing is to be resumed."""
        with contextlib.suppress(OSError):
            os.remove(self.path)
        os.close(self._file)
