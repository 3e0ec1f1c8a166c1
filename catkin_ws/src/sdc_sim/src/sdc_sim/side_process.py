"""Hands work to a process of its own, so that it neither shares an interpreter with the loop that drives nor can hold it up."""
from __future__ import annotations

import contextlib
import json
import os
import socket
import subprocess
import threading


class SideProcess:
    """A program that is given items, one JSON text a line, and says with one byte each when it has done them.

    command: the program; the number of its socket is added as the last argument, see `serve`. depth: how many items may be on
    their way. warn: called with one line when the program ended by itself, which starts it anew, or has fallen behind.
    files: numbers of open files that the program is to have, too.
    """

    def __init__(self, command: list, depth: int, warn, files=()):
        self._command = command
        self._files = tuple(files)
        self._depth = depth
        self._warn = warn
        self._changed = threading.Condition()
        self._pending = 0
        self._behind = False
        self._closed = False
        self._start()

    def _start(self):
        self._socket, theirs = socket.socketpair()
        with theirs:
            # rospy gives new sockets a time-out, which the other side would inherit as reads that do not wait.
            self._socket.settimeout(None)
            theirs.settimeout(None)
            self.process = subprocess.Popen([*self._command, str(theirs.fileno())], pass_fds=(theirs.fileno(), *self._files),
                                            stdin=subprocess.DEVNULL, start_new_session=True)
        self._pending = 0
        threading.Thread(target=self._count_done, args=(self._socket, self.process), daemon=True).start()

    def _count_done(self, connection, process):
        with contextlib.suppress(OSError):
            while True:
                done = connection.recv(4096)
                if not done:
                    break
                with self._changed:
                    self._pending -= len(done)
                    self._behind = False
                    self._changed.notify_all()
        process.wait()
        with self._changed:
            if not self._closed:
                connection.close()
                self._warn(f"ended with {process.returncode} and was started anew")
                self._start()
            self._changed.notify_all()

    def offer(self, item) -> bool:
        """Give it the item unless it is still busy with another; returns whether it was given."""
        with self._changed:
            return self._pending < 1 and self._give(item)

    def put(self, item, patience_s: float) -> bool:
        """Give it the item, after waiting up to patience_s of wall time for room; returns whether it was given.

        Who has once been too slow is not waited for again until it has done something.
        """
        with self._changed:
            if not self._behind and not self._changed.wait_for(lambda: self._pending < self._depth, patience_s):
                self._behind = True
                self._warn(f"has not answered for {patience_s:g} s; going on without it")
            return self._pending < self._depth and self._give(item)

    def _give(self, item) -> bool:
        try:
            self._socket.sendall(json.dumps(item).encode() + b"\n")
        except OSError:
            return False  # it has just ended
        self._pending += 1
        return True

    def drain(self, patience_s: float) -> bool:
        """Wait until all items are done; returns whether they are."""
        with self._changed:
            return self._changed.wait_for(lambda: self._pending == 0, patience_s)

    def close(self) -> None:
        """Tell it to end, and wait for that; what it has been given is still done."""
        with self._changed:
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
    with socket.socket(fileno=socket_number) as connection, connection.makefile("r", encoding="utf-8") as lines:
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
