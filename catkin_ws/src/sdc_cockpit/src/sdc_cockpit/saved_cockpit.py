"""What the cockpit needs after a crash, when its supervisor has started it again."""

from __future__ import annotations

import json
import os
from pathlib import Path

from sdc_cockpit.access import new_token
from sdc_common.ros.supervisor import STATE_FOLDER_VARIABLE


class SavedCockpit:
    """Token, port, and whether a person drives.

    Args:
        port: the port if there is nothing saved
    """

    def __init__(self, port: int):
        self.token, self.port, self.driving = new_token(), port, False
        self._path: Path | None = None
        if STATE_FOLDER_VARIABLE in os.environ:
            self._path = Path(os.environ[STATE_FOLDER_VARIABLE]) / "cockpit.json"
            if self._path.exists():
                saved = json.loads(self._path.read_text(encoding="ascii"))
                self.token, self.port, self.driving = saved

    def write(self, port: int | None = None, driving: bool = False) -> None:
        """Save new values; without a port, it stays."""
        self.port = self.port if port is None else port
        if self._path is None:
            return
        new = self._path.with_suffix(".new")
        new.touch(mode=0o600)
        new.write_text(json.dumps([self.token, self.port, driving]), encoding="ascii")
        new.replace(self._path)
