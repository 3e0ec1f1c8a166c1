"""Publishes pictures beside the loop that drives."""
from __future__ import annotations

import queue
import threading


class Background:
    """Calls a function with the items put in, one after the other, in a thread of its own.

    `put` waits while an earlier item is still in work (so that no item is lost); `offer` drops its item then instead.
    An exception in the function is raised by the next `put` or `offer`.
    """

    def __init__(self, work):
        self._work = work
        self._items = queue.Queue(maxsize=1)
        self._error = None
        threading.Thread(target=self._run, daemon=True).start()

    def put(self, item) -> None:
        self._check()
        self._items.put(item)

    def offer(self, item) -> bool:
        """Returns whether the item was taken."""
        self._check()
        try:
            self._items.put_nowait(item)
        except queue.Full:
            return False
        return True

    def _check(self):
        if self._error is not None:
            raise self._error

    def _run(self):
        while True:
            item = self._items.get()
            try:
                self._work(item)
            except Exception as error:  # noqa: BLE001  handed to the caller's thread, which would otherwise wait for ever
                self._error = error
                return
