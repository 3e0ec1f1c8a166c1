"""Requests of other threads to the loop of a node."""

from __future__ import annotations

import queue
import time
from typing import Any, Callable

import rospy

_SHUTDOWN_CHECK_S = 0.5


class RequestQueue:
    """Function calls that ROS callbacks post and that the loop executes between two ticks.

    All state then belongs to the thread of the loop and needs no locks.
    """

    def __init__(self) -> None:
        # Not a SimpleQueue: with a short timeout, its `get` can wait forever (CPython 3.11).
        self._requests: queue.Queue = queue.Queue()

    def post(self, function: Callable, *arguments: Any) -> None:
        """Have the loop call the function; do not wait."""
        self._requests.put((function, arguments))

    def deferred(self, function: Callable) -> Callable[[Any], None]:
        """Return a subscriber callback that posts a call of this function with the message."""

        def callback(message: Any) -> None:
            self._requests.put((function, (message,)))

        return callback

    def call(self, function: Callable[[], Any]) -> Any:
        """Have the loop call the function; wait for its result.

        Raises:
            rospy.ServiceException: the node shuts down before
        """
        result: queue.Queue = queue.Queue()
        self.post(lambda: result.put(function()))
        while not rospy.is_shutdown():
            try:
                return result.get(timeout=_SHUTDOWN_CHECK_S)
            except queue.Empty:
                pass
        raise rospy.ServiceException("the node shuts down")

    def process_until(self, deadline_s: float, done: Callable[[], bool] | None = None) -> bool:
        """Execute requests until `done()`, which is tested after each of them, or the deadline.

        After the deadline only those requests are executed that were in the queue at the call:
        no number of requests stops the loop.

        Args:
            deadline_s: time of time.monotonic()
            done: condition to return earlier

        Returns:
            whether `done()`
        """
        queued = self._requests.qsize()
        while done is None or not done():
            left_s = deadline_s - time.monotonic()
            if left_s <= 0.0 and queued <= 0:
                return False
            try:
                function, arguments = self._requests.get(timeout=max(left_s, 0.0))
            except queue.Empty:
                return False
            queued -= 1
            function(*arguments)
        return True
