"""The loop of a node executes the requests of other threads."""

import threading
import time

from sdc_sim.ros.request_queue import RequestQueue


def now_plus(seconds):
    return time.monotonic() + seconds


def test_requests_execute_in_order_in_the_thread_of_the_loop():
    requests, executed = RequestQueue(), []
    add = requests.deferred(lambda message: executed.append((message, threading.get_ident())))
    threads = [threading.Thread(target=add, args=(n,)) for n in range(3)]
    for thread in threads:
        thread.start()
        thread.join()
    requests.process_until(now_plus(0.0))
    assert executed == [(n, threading.get_ident()) for n in range(3)]


def test_loop_returns_as_soon_as_its_condition_is_true():
    requests, executed = RequestQueue(), []
    for n in range(3):
        requests.post(executed.append, n)
    assert requests.process_until(now_plus(60.0), lambda: len(executed) == 2)
    assert executed == [0, 1]


def test_loop_returns_at_the_deadline():
    started = time.monotonic()
    assert not RequestQueue().process_until(started + 0.05, lambda: False)
    assert 0.05 <= time.monotonic() - started < 5.0


def test_loop_returns_however_near_the_deadline_is():
    requests = RequestQueue()

    def loop():
        for n in range(50_000):
            requests.process_until(now_plus(n % 100 * 5e-8))
            requests.post(lambda: None)
            requests.process_until(now_plus(0.0))

    thread = threading.Thread(target=loop, daemon=True)
    thread.start()
    thread.join(60.0)
    assert not thread.is_alive()


def test_flood_of_requests_does_not_hold_the_loop_after_the_deadline():
    requests = RequestQueue()

    def repeat():
        requests.post(repeat)

    repeat()
    started = time.monotonic()
    requests.process_until(started + 0.05)
    assert time.monotonic() - started < 5.0


def test_late_loop_still_executes_the_requests_that_wait():
    requests, executed = RequestQueue(), []
    requests.post(executed.append, 1)
    requests.process_until(now_plus(-1.0))
    assert executed == [1]


def test_call_returns_the_result_of_the_loop():
    requests, calls, results = RequestQueue(), [], []

    def answer():
        calls.append(1)
        return 42

    caller = threading.Thread(target=lambda: results.append(requests.call(answer)))
    caller.start()
    requests.process_until(now_plus(60.0), lambda: bool(calls))
    caller.join(10.0)
    assert results == [42]
