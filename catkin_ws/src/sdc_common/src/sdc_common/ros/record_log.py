"""An append-only file of records that survives the death of the process that writes it.

File format: frames without a gap. A frame is the length of the body and its CRC-32, each a
little-endian unsigned 32-bit integer, and the body: one record in Python's marshal format, version
2. Marshal takes an eighth of the time that JSON takes, and a node saves its state in every tick.
"""

from __future__ import annotations

import contextlib
import errno
import marshal
import os
import struct
import zlib
from collections.abc import Iterator

_FRAME_HEAD = struct.Struct("<II")
_MARSHAL_VERSION = 2
_FLAGS = os.O_RDWR | os.O_CREAT | os.O_APPEND


class RecordLog:
    """A file of records: numbers, strings and None in tuples, lists and dicts.

    NumPy numbers are not plain data: marshal stores them as bytes. Convert them to Python numbers
    first.

    Each record is one write call. A killed process loses at most the record that it is writing; a
    power failure can lose more. Opening the file drops the first damaged frame and all that follows
    it. A file that another user owns counts as empty, because marshal data can crash the reader.

    A full disk and a missing folder raise nothing: `failure` holds the OSError, or None. After a
    failure, the log accepts no more records.
    """

    def __init__(self, path: str):
        """Open the file, or create it.

        Args:
            path: the file; its folder must exist
        """
        self.path = path
        self.failure: OSError | None = None
        self._file = -1
        self._size = 0
        self._last_offset = -1
        try:
            self._file = os.open(path, _FLAGS, 0o600)
            self._keep_whole_frames()
        except OSError as error:
            self._fail(error)

    @property
    def size_bytes(self) -> int:
        """Return the size of all whole records."""
        return self._size

    def append(self, record: object) -> bool:
        """Append one record.

        Returns:
            whether the record is in the file

        Raises:
            ValueError: the record is not plain data
        """
        if self.failure is not None:
            return False
        frame = _frame(record)
        try:
            written = os.write(self._file, frame)
        except OSError as error:
            return self._fail(error)
        if written != len(frame):
            return self._fail(OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
        self._last_offset = self._size
        self._size += written
        return True

    def replace(self, record: object) -> bool:
        """Replace all records by this one, atomically.

        Returns:
            whether the record is in the file
        """
        if self.failure is not None:
            return False
        frame = _frame(record)
        new_path = self.path + ".new"
        try:
            new_file = os.open(new_path, _FLAGS | os.O_TRUNC, 0o600)
            try:
                if os.write(new_file, frame) != len(frame):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                os.replace(new_path, self.path)
            except OSError:
                os.close(new_file)
                with contextlib.suppress(OSError):
                    os.remove(new_path)
                raise
        except OSError as error:
            return self._fail(error)
        os.close(self._file)
        self._file, self._size, self._last_offset = new_file, len(frame), 0
        return True

    def clear(self) -> None:
        """Remove all records; the file stays."""
        self._size, self._last_offset = 0, -1
        if self._file >= 0:
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, 0)

    def records(self) -> Iterator:
        """Yield all records, the oldest first."""
        for _, body in self._frames(self._size):
            yield marshal.loads(body)

    def last(self) -> object:
        """Return the newest record, or None if there is none."""
        if self._last_offset < 0:
            return None
        body = os.pread(self._file, self._size, self._last_offset)[_FRAME_HEAD.size :]
        return marshal.loads(body)

    def close(self) -> None:
        """Close the file."""
        if self._file >= 0:
            os.close(self._file)
            self._file, self._size, self._last_offset = -1, 0, -1
            self.failure = self.failure or OSError(errno.EBADF, os.strerror(errno.EBADF), self.path)

    def __del__(self):
        self.close()

    def remove(self) -> None:
        """Close the file and delete it."""
        self.close()
        with contextlib.suppress(OSError):
            os.remove(self.path)

    def _keep_whole_frames(self) -> None:
        status = os.fstat(self._file)
        if status.st_uid == os.geteuid():
            for offset, body in self._frames(status.st_size):
                self._last_offset = offset
                self._size = offset + _FRAME_HEAD.size + len(body)
        if self._size < status.st_size:
            os.ftruncate(self._file, self._size)

    def _frames(self, end: int) -> Iterator:
        # Read through the open file: its folder can have been renamed or removed.
        offset = 0
        while offset + _FRAME_HEAD.size <= end:
            length, check = _FRAME_HEAD.unpack(os.pread(self._file, _FRAME_HEAD.size, offset))
            if not 0 < length <= end - offset - _FRAME_HEAD.size:
                return
            body = os.pread(self._file, length, offset + _FRAME_HEAD.size)
            if zlib.crc32(body) != check:
                return
            yield offset, body
            offset += _FRAME_HEAD.size + length

    def _fail(self, error: OSError) -> bool:
        self.failure = OSError(error.errno, error.strerror or str(error), self.path)
        return False


def _frame(record: object) -> bytes:
    body = marshal.dumps(record, _MARSHAL_VERSION)  # type: ignore[arg-type]
    return _FRAME_HEAD.pack(len(body), zlib.crc32(body)) + body
