"""The lock of a node's loop."""

from __future__ import annotations

import functools
import threading
from typing import Any, Callable

# A loop that is late still lets the callbacks of other threads run.
_LEAST_WAIT_S = 0.001


class LoopLock:
    """Lets callbacks of other threads change the state of a loop only while the loop waits.

    The loop holds the lock (`with`) except in `wait`.
    """

    def __init__(self) -> None:
        self._condition = threading.Condition()

    def __enter__(self) -> LoopLock:
        self._condition.acquire()
        return self

    def __exit__(self, *_error: object) -> None:
        self._condition.release()

    def call(self, function: Callable, *arguments: Any) -> Any:
        """Call a function while the loop waits, wake the loop up, and return the result."""
        with self._condition:
            try:
                return function(*arguments)
            finally:
                self._condition.notify_all()

    def guarded(self, function: Callable) -> Callable:
        """Return a callback that calls this function as `call` does."""
        return functools.partial(self.call, function)

    def wait(self, timeout_s: float, done: Callable[[], bool] = lambda: False) -> bool:
        """Wait until `done()`, which is tested after each callback, or until the timeout.

        Args:
            timeout_s: wall time, at least 1 ms
            done: condition to return earlier

        Returns:
            whether `done()`
        """
        return self._condition.wait_for(done, max(timeout_s, _LEAST_WAIT_S))
