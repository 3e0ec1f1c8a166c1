"""What both servers need: arguments, a port, a token, and programs that end with this one."""

from __future__ import annotations

import contextlib
import ipaddress
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from sdc_experiments.commands import WordError

PORTS_TO_TRY = 50
TOKEN_VARIABLE = "JUPYTER_TOKEN"
_START_S = 120.0
_END_S = 10.0


class ServiceError(RuntimeError):
    """A server cannot start; the message names the fix."""


def free_port(address: str, first: int) -> int:
    """Return the first port from `first` on that is free. Raises ServiceError."""
    for port in range(first, min(first + PORTS_TO_TRY, 65536)):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            with contextlib.suppress(OSError):
                probe.bind((address, port))
                return port
    raise ServiceError(
        f"no port is free on {address} from {first} on; name an address of this machine with "
        "--ip, or another port with --port"
    )


def url(address: str, port: int, path: str) -> str:
    """Return the URL of a page as the person on this machine opens it."""
    return f"http://{'127.0.0.1' if address == '0.0.0.0' else address}:{port}/{path}"


class Programs:
    """Programs that run until the end of the `with` block, or until this process is killed."""

    def __init__(self, log: Path) -> None:
        self._log = log
        self._processes: list[subprocess.Popen] = []

    def __enter__(self) -> Programs:
        """Turn the signals that end a program into the end of the block."""
        for number in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, lambda *_: sys.exit(0))
        return self

    def __exit__(self, *_: object) -> None:
        """End the programs, the last one first."""
        for process in reversed(self._processes):
            process.terminate()
            try:
                process.wait(_END_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def start(
        self, command: Sequence[str], environment: Mapping[str, str], **options: object
    ) -> subprocess.Popen:
        """Start a program in a session of its own, so that Ctrl-C ends it only through this one."""
        with open(self._log, "ab") as output:
            process = subprocess.Popen(
                ["setpriv", "--pdeathsig", "TERM", *command],
                env=dict(environment),
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=output,
                start_new_session=True,
                **options,  # type: ignore[call-overload]
            )
        self._processes.append(process)
        return process

    def wait(self) -> None:
        """Wait until one of the programs ends. Raises ServiceError."""
        while True:
            for process in self._processes:
                if process.poll() is not None:
                    raise self.failure(process, f"ended with {process.returncode}")
            time.sleep(0.5)

    def wait_for_port(self, process: subprocess.Popen, address: str, port: int) -> None:
        """Wait until a program accepts connections. Raises ServiceError."""
        limit = time.monotonic() + _START_S
        to = "127.0.0.1" if address == "0.0.0.0" else address
        while time.monotonic() < limit and process.poll() is None:
            with contextlib.suppress(OSError), socket.create_connection((to, port), timeout=1.0):
                return
            time.sleep(0.1)
        raise self.failure(process, "does not start")

    def failure(self, process: subprocess.Popen, what: str) -> ServiceError:
        """Return an error with the last line of the log."""
        lines = self._log.read_text(encoding="utf-8", errors="replace").split("\n")
        last = next(filter(str.strip, reversed(lines)), "no output")
        return ServiceError(f"{os.path.basename(process.args[3])} {what}: {last.strip()}")


@contextlib.contextmanager
def errors_in_one_line(program: str) -> Iterator[None]:
    """Turn an error of this module, a word or a file into one line and status 1; Ctrl-C into 0."""
    try:
        yield
    except (ServiceError, WordError, OSError) as error:
        print(f"{program}: {error}", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(0)


def announce(program: str, where: str, address: str) -> None:
    """Print the URL, and a warning if the network reaches it."""
    print(f"{program}: {where}", flush=True)
    if not ipaddress.ip_address(address).is_loopback:
        print(
            f"{program}: it listens on {address}, without encryption: anyone who reaches this port "
            "and knows the token can run programs here",
            file=sys.stderr,
            flush=True,
        )
