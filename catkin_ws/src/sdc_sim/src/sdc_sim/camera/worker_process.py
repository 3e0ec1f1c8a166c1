"""A worker process with an interpreter of its own, so that its work cannot delay the caller's."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
import time
from multiprocessing import resource_tracker, util
from multiprocessing.connection import Connection
from typing import Any, Callable, Sequence

# The start includes imports and make_handler, on a machine that starts other nodes as well.
_START_TIMEOUT_S = 120.0
_END_TIMEOUT_S = 5.0
# Spawn, not fork: a fork of a process with threads may inherit locks that are never released.
_CONTEXT = multiprocessing.get_context("spawn")


class WorkerProcess:
    """A process that handles items one after the other.

    It finishes the items that it was sent when it is closed, which the end of the caller does,
    too, and when the caller is killed. It ignores SIGINT, which a terminal sends to the caller and
    to its children. It may have a worker process of its own.

    Attributes:
        process: the process that runs now
    """

    def __init__(
        self,
        make_handler: Callable[..., Callable[[Any], None]],
        arguments: Sequence[Any],
        depth: int,
        warn: Callable[[str], None],
        idle: bool = False,
    ):
        """Start the process.

        Args:
            make_handler: called in the process with `arguments`; returns the function that handles
                an item. Must be importable by name.
            arguments: arguments that pickle can serialize
            depth: how many items may be sent and not handled yet
            warn: called with one line when the process ended by itself or is too slow
            idle: whether it gets only the processor time that no other process uses, as do its own
                worker processes
        """
        self._make_handler = make_handler
        self._arguments = tuple(arguments)
        self._depth = depth
        self._warn = warn
        self._idle = idle
        self._lock = threading.Lock()
        self._slow = False
        self._closed = False
        self._start()
        # multiprocessing waits for its processes at the end, after the functions that it lists.
        util.Finalize(None, self.close, exitpriority=0)

    def _start(self) -> None:
        self._connection, theirs = _CONTEXT.Pipe()
        self._pending = 1  # the process acknowledges its start like an item
        self._starting = True
        self._ended = False
        self.process = _CONTEXT.Process(
            target=_serve,
            args=(theirs, self._make_handler, self._arguments, self._idle),
        )
        # The process inherits the blocked SIGINT, which it would not ignore before it runs _serve.
        # The start of the resource tracker unblocks SIGINT, so the tracker must run already.
        resource_tracker.ensure_running()
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
        try:
            self.process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        theirs.close()

    def offer(self, item: Any) -> bool:
        """Send an item unless the process is busy or starts.

        Args:
            item: an object that pickle can serialize

        Returns:
            whether it was sent
        """
        with self._lock:
            return not self._closed and self._wait(0, 0.0) and self._send(item)

    def put(self, item: Any, timeout_s: float) -> bool:
        """Send an item; wait while `depth` items are not handled yet.

        After a timeout, calls do not wait until the process has handled another item.

        Args:
            item: an object that pickle can serialize
            timeout_s: limit of the wait, in wall time [s]; longer while the process starts

        Returns:
            whether it was sent
        """
        with self._lock:
            if self._closed:
                return False
            limit_s = _START_TIMEOUT_S if self._starting else timeout_s
            room = self._wait(self._depth - 1, 0.0 if self._slow else limit_s)
            if not room and not self._slow:
                self._slow = True
                step = "start" if self._starting else "finish an item"
                self._warn(f"did not {step} within {limit_s:g} s; items are dropped")
            return room and self._send(item)

    def close(self) -> None:
        """Let the process finish the items that it was sent, and wait until it has ended."""
        with self._lock:
            self._closed = True
            self._connection.close()
        self._join()

    def _join(self) -> None:
        self.process.join(_END_TIMEOUT_S)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()

    def _wait(self, pending: int, timeout_s: float) -> bool:
        """Wait until at most `pending` items are not handled yet; return whether that happened."""
        deadline = time.monotonic() + timeout_s
        self._receive(0.0)
        while self._pending > pending and not self._ended:
            left_s = deadline - time.monotonic()
            if left_s <= 0.0:
                return False
            self._receive(left_s)
        return True

    def _receive(self, timeout_s: float) -> None:
        """Wait for an acknowledgement of the process, and count all that have arrived."""
        try:
            while not self._ended and self._connection.poll(timeout_s):
                self._connection.recv_bytes()
                self._pending -= 1
                self._starting = self._slow = False
                timeout_s = 0.0
        except (EOFError, OSError):
            self._ended = True

    def _send(self, item: Any) -> bool:
        if self._ended:
            self._connection.close()
            self._join()
            self._warn(f"ended with exit code {self.process.exitcode}; restarting it")
            self._start()
        try:
            self._connection.send(item)
        except OSError:
            self._ended = True  # the next call restarts it
            return False
        self._pending += 1
        return True


def _serve(
    connection: Connection,
    make_handler: Callable[..., Callable[[Any], None]],
    arguments: Sequence[Any],
    idle: bool,
) -> None:
    """Handle items until the caller closes the connection or ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # In a session of its own it is out of reach of signals to the caller's process group, and
    # Linux' autogroup scheduling gives it a share of the processor despite SCHED_IDLE.
    os.setsid()
    if idle:
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    started = threading.Event()
    threading.Thread(target=_end_without_caller, args=(started,), daemon=True).start()
    handle = make_handler(*arguments)
    started.set()
    while True:
        # A caller that has ended does not read acknowledgements, but its last items are handled.
        with contextlib.suppress(OSError):
            connection.send_bytes(b"")
        try:
            item = connection.recv()
        except (EOFError, OSError):
            return
        handle(item)


def _end_without_caller(started: threading.Event) -> None:
    """End this process if the caller ends before it has started: rospy waits for a roscore."""
    multiprocessing.parent_process().join()  # type: ignore[union-attr]
    if not started.is_set():
        os._exit(1)
