"""What a node must know to go on where it was killed: kept in files that keep_running gives it a folder for."""

from __future__ import annotations

import marshal
import os
import struct
import zlib

FOLDER = "NODE_STATE_FOLDER"
_HEAD = struct.Struct("<QII")


class Checkpoint:
    """The latest state of a node as plain data: numbers, strings and None in tuples, lists and dicts. Two files take turns, so that one
    is always whole.

    A write goes to the system's memory in one call and costs microseconds: a killed process loses none, a machine without
    power does. Without the folder (a node that keep_running did not start) nothing is kept. A disk that is full costs
    the state, never the drive: `problem` then says what went wrong.
    """

    def __init__(self):
        self.problem = None
        self._number = 0
        folder = os.environ.get(FOLDER)
        self._paths = [os.path.join(folder, f"state{n}") for n in (0, 1)] if folder else []
        self._files = []

    def load(self):
        """The newest state that was kept whole, or None."""
        found = [entry for entry in map(_read, self._paths) if entry]
        if not found:
            return None
        self._number, state = max(found, key=lambda entry: entry[0])
        return state

    def save(self, state: dict) -> bool:
        """Keep this state in place of the one before the last; returns whether it is kept."""
        if not self._paths or self.problem:
            return False
        try:
            if not self._files:
                self._files = [os.open(path, os.O_RDWR | os.O_CREAT, 0o600) for path in self._paths]
            self._number += 1
            # A tenth of JSON's time, on the way from a command to the tick that it asks for. Nobody else reads or writes the folder.
            body = marshal.dumps(state)
            entry = _HEAD.pack(self._number, len(body), zlib.crc32(body)) + body
            if os.pwrite(self._files[self._number % 2], entry, 0) != len(entry):
                self.problem = "the disk is full"
        except OSError as error:
            self.problem = error.strerror or str(error)
        return self.problem is None


def _read(path):
    """(number, state) of a file; None where there is none, or one that was not written to its end."""
    try:
        with open(path, "rb") as file:
            content = file.read()
        number, length, check = _HEAD.unpack_from(content)
    except (OSError, struct.error):
        return None
    body = content[_HEAD.size : _HEAD.size + length]
    if len(body) != length or zlib.crc32(body) != check:
        return None
    return number, marshal.loads(body)
