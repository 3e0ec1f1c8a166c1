"""Programs that tests start, with their output."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Callable

from sdc_common.processes import matching, processes_with

_TIMEOUT_S = 240.0
# A drive from start to end.
_END_TIMEOUT_S = 400.0
_SHOWN_CHARACTERS = 5000


def run(
    *command: object, folder: Path | str = ".", environment: Mapping[str, str] = os.environ
) -> subprocess.CompletedProcess[Any]:
    """Run a program in a folder until it ends; its output contains its errors."""
    return subprocess.run(
        [str(word) for word in command],
        cwd=folder,
        env={**environment, "PWD": os.path.abspath(folder)},
        timeout=_END_TIMEOUT_S,
        check=False,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    )


class Program:
    """A running program whose output goes to a file."""

    def __init__(
        self, command: Sequence[str], environment: Mapping[str, str], folder: Path, log: Path
    ):
        """Start a program.

        Args:
            command: the program and its arguments
            environment: all its environment variables
            folder: its working directory
            log: the file that receives its output
        """
        self.environment = environment
        self.log = log
        with open(log, "wb") as output:
            self.process = subprocess.Popen(
                command,
                cwd=folder,
                env={**environment, "PWD": str(folder), "PYTHONUNBUFFERED": "1"},
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    @property
    def output(self) -> str:
        """Return all output so far."""
        return self.log.read_text(errors="replace")

    def wait_for_output(self, *texts: str) -> None:
        """Wait until the output contains all texts; errors as in `wait_for_match`."""
        for text in texts:
            self.wait_for_match(f"({re.escape(text)})")

    def wait_for_match(self, pattern: str) -> str:
        """Wait until the output matches a regular expression; return its first group.

        End the pattern with the space or line end after the group: a line may still be written.

        Raises:
            AssertionError: there is no match after a timeout, or at the end of the program
        """
        limit = time.monotonic() + _TIMEOUT_S
        while True:
            ended = self.process.poll() is not None
            output = self.output
            match = re.search(pattern, output)
            if match:
                return match[1]
            shown = output[-_SHOWN_CHARACTERS:]
            assert not ended, f"the program ended without {pattern}:\n{shown}"
            assert time.monotonic() < limit, f"timeout without {pattern}:\n{shown}"
            time.sleep(0.05)

    def wait_for_end(self, timeout_s: float = _END_TIMEOUT_S) -> int:
        """Return the exit status."""
        return self.process.wait(timeout_s)

    def interrupt(self) -> int:
        """Send one Ctrl-C; return the exit status."""
        self.process.send_signal(signal.SIGINT)
        return self.wait_for_end()

    def kill(self) -> None:
        """End the program and what it started."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()

    def pid_of(self, word: str) -> int:
        """Return the id of the one process of this ROS master whose program name has a word."""
        uri = self.environment["ROS_MASTER_URI"]
        found = matching(
            processes_with("ROS_MASTER_URI", uri),
            lambda process: any(word in os.path.basename(name) for name in process.cmdline()[:3]),
        )
        assert len(found) == 1, f"{word}: {found}"
        return found[0].pid


@contextlib.contextmanager
def programs(
    folder: Path, end: Callable[[Program], object] = Program.interrupt
) -> Iterator[Callable[..., Program]]:
    """Yield a function that starts programs, and end those that still run at the end."""
    begun: list[Program] = []

    def start(
        *command: object, environment: Mapping[str, str] = os.environ, cwd: Path = folder
    ) -> Program:
        words = [str(word) for word in command]
        begun.append(Program(words, environment, cwd, folder / f"log{len(begun)}"))
        return begun[-1]

    yield start
    for program in begun:
        end(program)
