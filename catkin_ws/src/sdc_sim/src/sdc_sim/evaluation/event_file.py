"""The events of a drive, in a file next to its report until the report is complete."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable, Iterable, Iterator
from errno import ENOSPC


class EventFile:
    """Appends events of DriveEvaluation, a line of JSON each.

    Each event is one system call, so that a killed process loses at most the one that it writes.
    An event that cannot be written, as on a full disk, is kept in memory.
    """

    def __init__(self, path: str, on_failure: Callable[[OSError], None] = lambda error: None):
        """Start an empty file; `on_failure` is called once, when an event cannot be written.

        Raises:
            OSError: the file cannot be written
        """
        self.path = path
        self._on_failure = on_failure
        self._unwritten: list = []
        # Another process that still reads the file of an older drive keeps it.
        with contextlib.suppress(FileNotFoundError):
            os.remove(path)
        self._file = open(path, "a+b", buffering=0)  # noqa: SIM115  open until the end

    def append(self, event: list) -> None:
        """Append one event; after `remove`, do nothing."""
        if self._file.closed:
            return
        if not self._unwritten:
            line = json.dumps(event).encode() + b"\n"
            try:
                if self._file.write(line) == len(line):
                    return
                self._on_failure(OSError(ENOSPC, os.strerror(ENOSPC), self.path))
            except OSError as error:
                self._on_failure(OSError(error.errno, error.strerror, self.path))
        self._unwritten.append(event)

    def events(self) -> Iterator:
        """Yield all events, the oldest first."""
        self._file.seek(0)
        with open(self._file.fileno(), "rb", closefd=False) as lines:
            yield from _parsed(lines)
        yield from self._unwritten

    def remove(self) -> None:
        """Remove the file: the drive is reported."""
        self._file.close()
        with contextlib.suppress(OSError):
            os.remove(self.path)


def read_events(path: str) -> Iterator:
    """Yield the events of a drive whose process has ended.

    Raises:
        OSError: the file cannot be read
        ValueError: it is no file of events
    """
    with open(path, "rb") as lines:
        yield from _parsed(lines)


def _parsed(lines: Iterable[bytes]) -> Iterator:
    # The last line can be incomplete.
    return (json.loads(line) for line in lines if line.endswith(b"\n"))
