"""The lock of a node's loop."""

from __future__ import annotations

import threading
from typing import Any, Callable

# A loop that is late still lets the callbacks of other threads run.
_LEAST_WAIT_S = 0.001


class LoopLock(threading.Condition):
    """Lets callbacks of other threads change the state of a loop only while the loop waits.

    The loop holds the lock (`with`) except in `wait_until`.
    """

    def __init__(self) -> None:
        super().__init__()
        # Does the work of the loop in the callback's thread, and returns whether it did. To wake
        # the loop's thread takes some percent of a tick.
        self.proceed: Callable[[], bool] = lambda: False

    def guarded(self, function: Callable) -> Callable:
        """Return a callback that calls this function while the loop waits, and continues it."""

        def call(*arguments: Any) -> Any:
            with self:
                try:
                    return function(*arguments)
                finally:
                    if not self.proceed():
                        self.notify_all()

        return call

    def wait_until(self, timeout_s: float, done: Callable[[], bool] = lambda: False) -> bool:
        """Wait until `done()`, which is tested after each callback, or until the timeout.

        Returns:
            whether `done()`
        """
        return self.wait_for(done, max(timeout_s, _LEAST_WAIT_S))
