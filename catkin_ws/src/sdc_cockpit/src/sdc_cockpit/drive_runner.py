"""Drives that a page starts and stops, and the reports of the past ones."""

from __future__ import annotations

import base64
import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any, Callable

from sdc_common.configuration import package_folder

_REPORT, _PAGE, _LOG, _DRIVE = "report.json", "report.html", "drive.log", "drive.json"
_METRICS = (
    *("status", "route_completion_percent", "duration_s"),
    *("cross_track_rms_m", "driving_score"),
)
# What ./drive prints: before each step of its preparation, and at the end of a drive that failed.
_PREPARE = "prepare: "
_FAILED = "drive: failed"
_ERROR = re.compile(r"\[(ERROR|FATAL)\]")
_COLOUR = re.compile(r"\x1b\[[\d;]*m")
_MAX_LISTED = 50
_COMPARE_LIMIT_S = 60.0
_END_LIMIT_S = 60.0


class DriveRunner:
    """Runs ./drive, one drive at a time. Each drive has a folder of its own.

    Methods may be called in any thread; `start` returns when the process runs.

    Args:
        command: path of ./drive; empty to offer no drives
        folder: where the folders of the drives are
        on_end: called in a thread of its own when a drive has ended
    """

    def __init__(self, command: str, folder: Path, on_end: Callable[[], object]):
        self._command, self._folder, self._on_end = command, folder, on_end
        self._lock = threading.Lock()
        self._process: subprocess.Popen | None = None
        self._name: str | None = None
        self.last: str | None = None  # the drive that ended last

    @property
    def offered(self) -> bool:
        """Return whether drives can be started."""
        return bool(self._command)

    @property
    def running(self) -> str | None:
        """Return the name of the drive that runs, None without one."""
        return self._name

    @property
    def phase(self) -> str:
        """Return what the running drive does before it has nodes, "" without a drive."""
        if (name := self._name) is None:
            return ""
        lines = _lines(self._folder / name / _LOG)
        if lines and lines[-1].startswith(_PREPARE):
            return lines[-1][len(_PREPARE) :]
        return "starting the nodes" if lines else "starting"

    def start(
        self, scenario: str, arguments: list[str], prepare: Callable[[], object] = lambda: None
    ) -> str:
        """Start a drive and return its name.

        Args:
            scenario: its name becomes a part of the drive's name
            arguments: arguments of ./drive, already checked
            prepare: called before the drive starts; what it raises prevents the start

        Raises:
            ValueError: a drive runs already, or none are offered
            OSError: the folder cannot be written, or the command cannot run
        """
        if not self._command:
            raise ValueError(
                "this page belongs to one drive; ./cockpit serves one that starts drives"
            )
        with self._lock:
            if self._name is not None:
                raise ValueError(f"the drive {self._name} runs; stop it first")
            prepare()
            name = time.strftime("%Y%m%d-%H%M%S-") + (scenario or "route")
            place = self._folder / name
            place.mkdir(parents=True)
            (place / _DRIVE).write_text(json.dumps({"arguments": arguments}), encoding="utf-8")
            # The drive ends with this process, also when it is killed.
            command = ["setpriv", "--pdeathsig", "TERM", self._command, *arguments]
            command += ["headless:=true", "cockpit:=false", f"report:={place / _REPORT}"]
            with open(place / _LOG, "wb") as log:
                self._process = subprocess.Popen(
                    command,
                    cwd=place,
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                )
            self._name = name
        waiting = (self._process, place, arguments)
        threading.Thread(target=self._wait, args=waiting, daemon=True).start()
        return name

    def stop(self) -> None:
        """Ask the running drive to end; it still writes its report.

        Raises:
            ValueError: no drive runs
        """
        process = self._process
        if process is None or self._name is None:
            raise ValueError("no drive runs")
        with contextlib.suppress(ProcessLookupError):
            process.send_signal(signal.SIGTERM)

    def end(self) -> None:
        """Stop the running drive, if there is one, and wait for its end."""
        process = self._process
        with contextlib.suppress(ValueError, subprocess.TimeoutExpired):
            self.stop()
            if process is not None:
                process.wait(_END_LIMIT_S)

    def _wait(self, process: subprocess.Popen, place: Path, arguments: list[str]) -> None:
        status = process.wait()
        content = {"arguments": arguments, "exit_status": status}
        with contextlib.suppress(OSError):
            (place / _DRIVE).write_text(json.dumps(content), encoding="utf-8")
        self.last, self._name = self._name, None
        self._on_end()

    def past(self) -> list[dict[str, Any]]:
        """Return the drives that have ended, the newest first."""
        names = sorted(self._names(), reverse=True)
        return [self._row(name) for name in names[:_MAX_LISTED] if name != self._name]

    def _row(self, name: str) -> dict[str, Any]:
        place = self._folder / name
        drive, metrics = _json(place / _DRIVE), metrics_of(place / _REPORT)
        return {
            "name": name,
            "arguments": drive.get("arguments", []),
            "exit_status": drive.get("exit_status"),
            "page": (place / _PAGE).exists(),
            "problem": _problem(place, drive.get("exit_status"), metrics["status"] is not None),
            **metrics,
        }

    def file(self, name: str, file: str) -> Path | None:
        """Return the path of a drive's report page or log; None if there is no such file."""
        if name not in self._names() or file not in (_PAGE, _LOG):
            return None
        path = self._folder / name / file
        return path if path.is_file() else None

    def comparison(self, a: str, b: str) -> dict[str, str]:
        """Return the text of compare.py for two drives, and its picture as a data URL.

        Raises:
            ValueError: there is no such drive, or it has no report
        """
        for name in (a, b):
            if name not in self._names():
                raise ValueError(f"there is no drive {name[:80]!r}")
        compare = os.path.join(package_folder("sdc_sim"), "scripts", "compare.py")
        with tempfile.TemporaryDirectory() as folder:
            picture = Path(folder) / "compare.png"
            done = subprocess.run(
                [sys.executable, compare, "--plot", str(picture), "--", a, b],
                cwd=self._folder,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=_COMPARE_LIMIT_S,
                check=False,
            )
            if done.returncode != 0:
                raise ValueError(done.stderr.strip().splitlines()[-1])
            text, url = done.stdout.partition("\nboth drives:")[0], ""
            if picture.exists():
                url = "data:image/png;base64," + base64.b64encode(picture.read_bytes()).decode()
        return {"text": text.strip(), "picture": url}

    def _names(self) -> set[str]:
        if not self._command:
            return set()
        folders = [path.parent for path in self._folder.glob(f"*/{_DRIVE}")]
        # A link may lead to any file that this user can read.
        return {
            folder.name
            for folder in folders
            if not any(path.is_symlink() for path in (folder, *folder.iterdir()))
        }


def metrics_of(report: str | Path) -> dict[str, Any]:
    """Return what a page shows of a report; each value is None if there is no report."""
    metrics = _json(Path(report))
    return {key: metrics.get(key) for key in _METRICS}


def _lines(log: Path) -> list[str]:
    try:
        text = log.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return []
    return [line.strip() for line in _COLOUR.sub("", text).splitlines() if line.strip()]


def _problem(place: Path, exit_status: int | None, has_report: bool) -> str:
    """Return the violated limits, or of a drive without a report the error; "" if none is known."""
    if not exit_status:
        return ""
    lines, prefix = _lines(place / _LOG), f"{place / _REPORT}: "
    problems = [line[len(prefix) :] for line in lines if line.startswith(prefix)]
    if not has_report:
        errors = [line for line in lines if _ERROR.match(line)]
        problems = (errors or [line for line in lines if line != _FAILED])[-1:]
    return "; ".join(problems)


def _json(path: Path) -> dict[str, Any]:
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return values if isinstance(values, dict) else {}
