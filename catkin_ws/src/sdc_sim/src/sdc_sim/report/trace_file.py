"""The trace of a drive, written to its file while the drive lasts."""

from __future__ import annotations

import contextlib
import csv
import math
import os
import tempfile
from collections.abc import Sequence
from typing import TextIO

import numpy as np

from sdc_sim.evaluation.command_matching import COMMAND_FIELDS
from sdc_sim.evaluation.route_progress import DriveSample

COLUMNS = (*DriveSample._fields, *COMMAND_FIELDS)
FIELDS = (*COLUMNS, "reason")
_PART = ".part"


class TraceFile:
    """The complete rows of a drive, in its CSV file and as numbers.

    At the end of a drive of many hours, only the last rows are left to be written. The file has the
    extension ".part" until `finish`. When the disk is full, `failure` holds the error; the event
    log still has all rows.
    """

    def __init__(self, path: str):
        """Open the file.

        Args:
            path: of the CSV file
        """
        self.failure: OSError | None = None
        self._path = path
        self.clear()

    def clear(self) -> None:
        """Remove all rows."""
        try:
            self._csv = open(self._path + _PART, "w", encoding="utf-8", newline="")  # noqa: SIM115
            folder = os.path.dirname(self._path) or "."
            self._numbers = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115
            write_rows(self._csv, [], [])
        except OSError as error:
            self.failure = error

    def append(self, rows: np.ndarray, reasons: Sequence[str]) -> None:
        """Store (n, 11) rows and what limited the speed in each."""
        if self.failure is not None:
            return
        try:
            write_rows(self._csv, rows.tolist(), reasons, header=False)
            self._numbers.write(rows.tobytes())
        except OSError as error:
            self.failure = error

    def rows(self) -> np.ndarray:
        """Return the numbers of all stored rows: (n, 11).

        Raises:
            OSError: they cannot be read
        """
        try:
            self._numbers.seek(0)
            numbers = np.frombuffer(self._numbers.read(), dtype=float)
        except OSError as error:
            self.failure = error
            raise
        return numbers.reshape(-1, len(COLUMNS))

    def finish(self, rows: np.ndarray, reasons: Sequence[str]) -> None:
        """Store the last rows and give the file its name.

        Raises:
            OSError: the file cannot be written
        """
        self.append(rows, reasons)
        if self.failure is not None:
            raise self.failure
        self._csv.close()
        os.replace(self._path + _PART, self._path)

    def remove(self) -> None:
        """Remove the unfinished file."""
        with contextlib.suppress(OSError):
            os.remove(self._path + _PART)


def write_rows(file: TextIO, rows: list, reasons: Sequence[str], header: bool = True) -> None:
    """Write rows with all digits; an unknown command or reason is empty."""
    writer = csv.writer(file)
    if header:
        writer.writerow(FIELDS)
    for row, reason in zip(rows, reasons):
        writer.writerow([*("" if math.isnan(value) else value for value in row), reason])
