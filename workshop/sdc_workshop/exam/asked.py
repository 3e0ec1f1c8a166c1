"""Ask for values of a student's module, which runs in a process of its own.

What asks runs in the check: the world and the referee of a drive, for example. A question is one
message over a socket, as to a driver of the championship. The student's process sends JSON, which
is no program.
"""

from __future__ import annotations

import io
import json
import pickle
import select
import socket
from types import SimpleNamespace
from typing import Any

import numpy as np

from sdc_workshop.exam.probes import library_probe
from sdc_workshop.exam.stage import NEVER_RETURNED, Stage

# CPU time for all answers of a module; those of the solution take a second, on a slow machine ten.
_MOST_CPU_S = 20.0
# A function that sleeps for so many times Program's IDLE_S does not return.
_MOST_IDLE = 4
_POLL_S = 0.02


class NoAnswer(Exception):
    """The student's process gives no answer; the message says why, or is empty if it has ended."""


class Asked:
    """A student's module in a process, `program`; the end of the `with` block ends it."""

    def __init__(self, stage: Stage, module: str, environment: dict):
        self._stage, self._module = stage, module
        self._link, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._link.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, library_probe.MAX_MESSAGE)
        # rospy gives each new socket a timeout, which does not wait in another process.
        for end in (self._link, theirs):
            end.settimeout(None)
        with theirs:
            command = ["/usr/bin/env", "python3", library_probe.__file__]
            self.program = stage.start(command, environment, stdin=theirs)

    def __enter__(self) -> Asked:
        return self

    def __exit__(self, *_: object) -> None:
        self._link.close()
        self.program.end()

    def begin(self, given: dict) -> None:
        """Let the process know these names, and forget those of the last call."""
        self.ask("begin(module, given)", module=self._module, given=given)

    def ask(self, expression: str, **names: object) -> Any:
        """Return the value of an expression in the student's process.

        Raises:
            NoAnswer: there is none
            ValueError, TypeError, ...: there is a strange one
        """
        message = io.BytesIO()
        _Question(message).dump((expression, names))
        try:
            self._link.send(message.getvalue())
            self._wait()
            answer = self._link.recv(library_probe.MAX_MESSAGE)
        except ConnectionError:
            answer = b""
        if not answer:
            self.program.wait()
            raise NoAnswer
        return self._restored(json.loads(answer))

    def _wait(self) -> None:
        """Wait for an answer, or the end of the process."""
        left_s = _MOST_CPU_S - self.program.activity()[0]
        for _ in range(_MOST_IDLE):
            how = self.program.wait_until(
                lambda: select.select([self._link], [], [], _POLL_S)[0], most_cpu_s=left_s
            )
            if how in ("true", "ended"):
                return
            if how != "idle":
                break
        self._stage.report(NEVER_RETURNED)
        raise NoAnswer("it never returns")

    def _restored(self, value: Any) -> Any:
        if isinstance(value, list):
            return [self._restored(part) for part in value]
        if not isinstance(value, dict):
            return value
        kind, content = value["type"], value["is"]
        if isinstance(content, dict):
            fields = {name: self._restored(field) for name, field in content.items()}
            return fields if kind == "dict" else type(kind, (SimpleNamespace,), {})(**fields)
        if isinstance(content, str):
            return type(kind, (Remote,), {})(self, content)
        return np.array(content)


class Remote:
    """An object in the student's process: its attributes and its calls are questions."""

    def __init__(self, asked: Asked, name: str):
        self._asked, self._name = asked, name

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return self._asked.ask("getattr(it, name)", it=self, name=name)

    def __call__(self, *arguments: object, **more: object) -> Any:
        """Return the result of its call there; see Asked.ask."""
        return self._asked.ask("it(*arguments, **more)", it=self, arguments=arguments, more=more)


class _Question(pickle.Pickler):
    def persistent_id(self, value: object) -> str | None:
        return value._name if isinstance(value, Remote) else None
