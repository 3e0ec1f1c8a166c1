"""Collect the measurements of one tick, whatever order they arrive in."""

from __future__ import annotations

import threading
from typing import Any, Callable, Sequence

# More messages than these wait only when a sensor has stopped.
_LONGEST_QUEUE = 100


class SensorPairing:
    """Calls `answer` once for each tick, with the messages that have its stamp.

    A tick is complete when each sensor that is due in it has arrived. Sensors that are not due in
    every tick are due at multiples of their periods. When the wheel speeds of the next tick arrive
    first, the tick is answered with what there is. Without wheel speeds or IMU it is left out. A
    lock serializes the calls of several threads.
    """

    def __init__(self, answer: Callable[..., None], periods_s: Sequence[float]):
        """Wait for `start()`.

        Args:
            answer: called with wheel speeds, IMU, and the message of each further sensor, or None
            periods_s: period of each further sensor; 0: it is never waited for
        """
        self._answer = answer
        self._periods_ns = [round(1e9 * period) for period in periods_s]
        self._received: list[dict[int, Any]] = [{} for _ in range(2 + len(periods_s))]
        self._answered_ns = -1
        self._started = False
        self._lock = threading.RLock()

    def start(self) -> None:
        """Answer what waits, and each tick from now on."""
        with self._lock:
            self._started = True
            self._answer_complete()

    def add(self, sensor: int, message: Any) -> None:
        """Add a message with a header: 0 is the wheel speeds, 1 the IMU, further ones follow."""
        with self._lock:
            stamp = message.header.stamp.to_nsec()
            if stamp > self._answered_ns:
                received = self._received[sensor]
                received[stamp] = message
                if len(received) > _LONGEST_QUEUE:
                    del received[min(received)]
                self._answer_complete()

    def _answer_complete(self) -> None:
        wheels, imus, *_ = self._received
        while self._started and wheels:
            stamp = min(wheels)
            if len(wheels) == 1 and not self._is_complete(stamp):
                return
            messages = [received.get(stamp) for received in self._received]
            self._answered_ns = stamp
            for received in self._received:
                for old in [other for other in received if other <= stamp]:
                    del received[old]
            if messages[1] is not None:
                self._answer(*messages)

    def _is_complete(self, stamp: int) -> bool:
        due = [True, True] + [period > 0 and stamp % period == 0 for period in self._periods_ns]
        return all(stamp in received for received, is_due in zip(self._received, due) if is_due)
