"""The latest state of a node, from which it resumes after it was killed."""

from __future__ import annotations

import os

from sdc_common.ros.record_log import RecordLog
from sdc_common.ros.supervisor import STATE_FOLDER_VARIABLE

_FILE_NAME = "checkpoint"
_MAX_SIZE_BYTES = 1_000_000


class Checkpoint:
    """A RecordLog of which only the newest record counts; the file stays below about 1 MB.

    Without a supervisor there is no folder and `save` does nothing.
    """

    def __init__(self):
        folder = os.environ.get(STATE_FOLDER_VARIABLE)
        self._log = RecordLog(os.path.join(folder, _FILE_NAME)) if folder else None

    @property
    def failure(self) -> OSError | None:
        """Return the error that stopped saving, such as a full disk, or None."""
        return self._log.failure if self._log else None

    def load(self) -> object:
        """Return the state that was saved last, or None if there is none."""
        return self._log.last() if self._log else None

    def save(self, state: object) -> bool:
        """Save a state of plain data, as RecordLog defines it.

        Returns:
            whether the state is saved
        """
        if self._log is None:
            return False
        if self._log.size_bytes > _MAX_SIZE_BYTES:
            return self._log.replace(state)
        return self._log.append(state)
