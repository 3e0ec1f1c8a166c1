"""Callbacks of other threads run while the loop of a node waits."""

import threading
import time

from sdc_sim.ros.loop_lock import LoopLock


def test_callback_runs_and_returns_its_result_only_while_the_loop_waits():
    lock, done, results = LoopLock(), [], []

    def answer(value):
        done.append(value)
        return value + 1

    callback = lock.guarded(answer)
    with lock:
        caller = threading.Thread(target=lambda: results.append(callback(41)))
        caller.start()
        time.sleep(0.05)
        assert done == []
        assert lock.wait_until(60.0, lambda: bool(done))
    caller.join(10.0)
    assert results == [42]


def test_late_loop_still_lets_callbacks_run():
    lock, done = LoopLock(), []
    with lock:
        threading.Thread(target=lock.guarded(done.append), args=(1,)).start()
        limit = time.monotonic() + 60.0
        while not done and time.monotonic() < limit:
            assert not lock.wait_until(-1.0)
    assert done == [1]
