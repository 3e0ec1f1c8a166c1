"""Hands work to a process of its own, so that it neither shares an interpreter with the loop that drives nor can hold it up."""

from __future__ import annotations

import contextlib
import json
import os
import select
import socket
import subprocess
import threading
import time


class SideProcess:
    """A program that is given items, one JSON text a line, and says with one byte each when it has done them.

    command: the program; the number of its socket is added as the last argument, see `serve`. depth: how many items may be on
    their way. warn: called with one line when the program had ended by itself, which starts it anew with the next item, or has
    fallen behind. files: numbers of open files that the program is to have, too.
    """

    def __init__(self, command: list, depth: int, warn, files=()):
        self._command = command
        self._files = tuple(files)
        self._depth = depth
        self._warn = warn
        self._lock = threading.Lock()
        self._behind = False
        self._closed = False
        self._start()

    def _start(self):
        self._socket, theirs = socket.socketpair()
        with theirs:
            # rospy gives new sockets a time-out, which the other side would inherit as reads that do not wait.
            self._socket.settimeout(None)
            theirs.settimeout(None)
            self.process = subprocess.Popen(
                [*self._command, str(theirs.fileno())],
                pass_fds=(theirs.fileno(), *self._files),
                stdin=subprocess.DEVNULL,
                start_new_session=True,
            )
        self._answers = select.poll()
        self._answers.register(self._socket, select.POLLIN)
        self._pending = 0
        self._ended = False

    def _hear(self, patience_s: float = 0.0) -> None:
        """Count what it says it has done; wait for a word of it if there is none."""
        if self._ended or not self._answers.poll(1e3 * patience_s):
            return
        try:
            done = len(self._socket.recv(4096))
        except OSError:
            done = 0
        self._pending -= done
        self._behind = self._behind and not done
        self._ended = not done

    def _wait(self, pending: int, patience_s: float) -> bool:
        """Wait until no more than so many items are on their way; returns whether that came to be."""
        limit = time.monotonic() + patience_s
        self._hear()
        while self._pending > pending and not self._ended:
            left_s = limit - time.monotonic()
            if left_s <= 0.0:
                return False
            self._hear(left_s)
        return True

    def offer(self, item) -> bool:
        """Give it the item unless it is still busy with another; returns whether it was given."""
        with self._lock:
            return self._wait(0, 0.0) and self._give(item)

    def put(self, item, patience_s: float) -> bool:
        """Give it the item, after waiting up to patience_s of wall time for room; returns whether it was given.

        Who has once been too slow is not waited for again until it has done something.
        """
        with self._lock:
            room = self._wait(self._depth - 1, 0.0 if self._behind else patience_s)
            if not room and not self._behind:
                self._behind = True
                self._warn(f"has not answered for {patience_s:g} s; going on without it")
            return room and self._give(item)

    def _give(self, item) -> bool:
        if self._closed:
            return False
        if self._ended:
            self._socket.close()
            self._warn(f"ended with {self.process.wait()} and was started anew")
            self._start()
        try:
            self._socket.sendall(json.dumps(item).encode() + b"\n")
        except OSError:
            return False  # it has just ended
        self._pending += 1
        return True

    def drain(self, patience_s: float) -> bool:
        """Wait until all items are done; returns whether they are."""
        with self._lock:
            return self._wait(0, patience_s) and self._pending == 0

    def close(self) -> None:
        """Tell it to end, and wait for that; what it has been given is still done."""
        with self._lock, contextlib.suppress(OSError):  # it may have ended by itself
            self._closed = True
            self._socket.shutdown(socket.SHUT_WR)
        try:
            self.process.wait(5.0)
        except subprocess.TimeoutExpired:
            self.process.kill()


def give_way() -> None:
    """Let whoever has something else to do run at once, for the rest of this process: work beside the loop must not delay it.

    With Linux' sched_autogroup, which shares the processor among sessions, the process still gets its session's share of it.
    """
    os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))


def serve(socket_number: int, work) -> None:
    """The other side: call work(item) for each item until the giver closes or ends."""
    with socket.socket(fileno=socket_number) as connection, connection.makefile(
        "r", encoding="utf-8"
    ) as lines:
        while True:
            try:
                line = lines.readline()
            except ConnectionError:
                return  # the giver was killed
            if not line:
                return
            work(json.loads(line))
            try:
                connection.send(b".")
            except OSError:
                return
