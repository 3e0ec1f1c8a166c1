"""The results of a sweep in a folder: one line for each drive, written as soon as it ends."""

from __future__ import annotations

import contextlib
import csv
import json
import os
from pathlib import Path
from typing import Any, Mapping, Sequence

from sdc_experiments.sweep.settings import text
from sdc_sim.report.writer import write_json

FAILED = "failed"
_IDENTITY = "study.json"
_ROWS = "drives.jsonl"
_LOGS = "logs"
# Display names of the parts of a study's identity.
_PARTS = {
    "files": "a scenario or another file of the study",
    "code": "the code, a configuration or a version",
}


class ResultsError(RuntimeError):
    """A folder whose results cannot be continued; the message is one line with the fix."""


class Results:
    """The rows of a sweep. They outlive a kill: each row is on the disk when `add` returns.

    Attributes:
        folder: the folder
        rows: the last row of each cell, by the key of the cell
    """

    def __init__(self, folder: Path, identity: Mapping[str, Any]):
        """Open a folder and read the rows of an interrupted sweep of the same identity.

        Raises:
            ResultsError: the folder holds results of another study, or another sweep writes them
            OSError: the folder cannot be written
        """
        self.folder = folder
        self.rows: dict[str, dict] = {}
        (folder / _LOGS).mkdir(parents=True, exist_ok=True)
        self._file = open(folder / _ROWS, "a+b")  # noqa: SIM115  it stays open until `close`
        try:
            self._lock()
            self._read()
            self._check(json.loads(json.dumps(identity)))
        except ResultsError:
            self._file.close()
            raise

    def _lock(self) -> None:
        import fcntl  # Other systems lack it.

        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise ResultsError(
                f"{self.folder}: another sweep writes its results here; wait for its end, or name "
                "another folder with --output"
            ) from None

    def _check(self, identity: dict) -> None:
        path = self.folder / _IDENTITY
        stored = None
        with contextlib.suppress(FileNotFoundError, ValueError):
            stored = json.loads(path.read_text(encoding="utf-8"))
        if stored is None or not self.rows:
            write_json(path, identity)
        elif stored != identity:
            changed = [name for name in identity if stored.get(name) != identity[name]]
            names = " and ".join(_PARTS.get(name, f"'{name}'") for name in changed)
            raise ResultsError(
                f"{self.folder}: these are the results of another study: {names} changed; name "
                "another folder with --output, or delete this one"
            )

    def _read(self) -> None:
        self._file.seek(0)
        end = 0
        for line in self._file:
            try:
                row = json.loads(line)
                self.rows[row["key"]] = row
            except (ValueError, KeyError, TypeError):
                break
            if not line.endswith(b"\n"):
                del self.rows[row["key"]]
                break
            end += len(line)
        # The last line was not complete when the sweep was killed.
        self._file.truncate(end)

    @property
    def finished(self) -> set[str]:
        """Return the keys of the cells that were driven; one that failed is driven again."""
        return {key for key, row in self.rows.items() if row["status"] != FAILED}

    @property
    def failed(self) -> list[dict]:
        """Return the rows of the cells that failed."""
        return [row for row in self.rows.values() if row["status"] == FAILED]

    def add(self, row: dict, log: str = "") -> None:
        """Store the row of a cell, and the log of a drive that failed."""
        if log:
            path = self.folder / _LOGS / f"{row['key']}.log"
            path.write_text(log, encoding="utf-8", errors="replace")
            row = {**row, "log": str(path.relative_to(self.folder))}
        self.rows[row["key"]] = row
        self._file.write(json.dumps(row).encode() + b"\n")
        self._file.flush()
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def table(rows: Sequence[Mapping]) -> list[dict[str, Any]]:
    """Return one flat row for each drive: settings, status, metrics."""
    flat_rows = []
    for row in rows:
        flat = {name: row[name] for name in ("key", "scenario")}
        for name, value in row["settings"].items():
            flat[name] = value if isinstance(value, (bool, int, float, str)) else text(value)
        flat.update({name: row.get(name, "") for name in ("seed", "status")})
        for name, value in row["metrics"].items():
            if isinstance(value, dict):
                flat.update({f"{name}_{inner}": entry for inner, entry in value.items()})
            elif name != "status":
                flat[name] = text(value) if isinstance(value, list) else value
        flat.update({name: row.get(name, "") for name in ("trace_sha256", "worker", "log")})
        flat_rows.append(flat)
    return flat_rows


def write_csv(path: Path, rows: Sequence[Mapping]) -> None:
    """Write rows into a CSV file."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(rows)
