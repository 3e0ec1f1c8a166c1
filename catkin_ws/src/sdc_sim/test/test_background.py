import threading

import pytest

from sdc_sim.background import Background


def test_put_loses_nothing_and_keeps_the_order():
    done, all_done = [], threading.Event()

    def work(item):
        done.append(item)
        if item == 99:
            all_done.set()
    background = Background(work)
    for item in range(100):
        background.put(item)
    assert all_done.wait(10.0)
    assert done == list(range(100))


def test_offer_drops_while_busy():
    go, started = threading.Event(), threading.Event()

    def work(_item):
        started.set()
        go.wait(10.0)
    background = Background(work)
    assert background.offer(1)
    assert started.wait(10.0)
    assert background.offer(2)
    assert not background.offer(3)
    go.set()


def test_error_reaches_the_caller():
    failed = threading.Event()

    def work(_item):
        failed.set()
        raise RuntimeError("no picture")
    background = Background(work)
    background.put(1)
    assert failed.wait(10.0)
    with pytest.raises(RuntimeError, match="no picture"):
        for _ in range(1000):
            background.offer(2)
            threading.Event().wait(0.01)
