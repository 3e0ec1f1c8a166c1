"""Handlers for the tests of WorkerProcess, which its process imports."""

import os
import time

from sdc_sim.camera.worker_process import WorkerProcess


def make_writer(path):
    """Return a handler that appends its items to a file."""

    def write(item):
        with open(path, "a", encoding="utf-8") as file:
            print(*item, file=file)

    return write


def make_waiter(path):
    """Return a handler that waits until a file exists."""

    def wait(_item):
        while not os.path.exists(path):
            time.sleep(0.01)

    return wait


def make_after(path):
    """Wait until a file exists; return a handler that does nothing."""
    make_waiter(path)(None)
    return lambda item: None


def make_stage(path):
    """Return a handler that hands its items to a worker process of its own."""
    worker = WorkerProcess(make_writer, (path,), 3, print)
    return lambda item: worker.put(item, 30.0)


def never_start(path):
    """Write the process id, and wait for ever."""
    with open(path, "a", encoding="utf-8") as file:
        print(os.getpid(), file=file)
    while True:
        time.sleep(0.1)
