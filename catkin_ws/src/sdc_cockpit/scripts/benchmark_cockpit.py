#!/usr/bin/env python3
"""Measure the cockpit: rate and latency of pictures, cost of viewers, and the speed in lockstep.

Usage: benchmark_cockpit.py [picture] [viewers] [lockstep]
"""

import asyncio
import contextlib
import json
import multiprocessing
import statistics
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil
import tornado.websocket
from sdc_cockpit.browser import headless_chromium, value_of, wait_for

from sdc_cockpit.protocol import CAMERA, read_picture
from sdc_common.processes import Program, isolated_ros_environment

VIEWERS = 30
SECONDS = 15.0
ROUNDS = 3
LOCKSTEP_ROUTE = Path("sdc_package/test/routes/fast_bends.csv")
SRC = Path(__file__).resolve().parents[2]


@contextlib.contextmanager
def running_drive(*arguments):
    """Run a drive with a cockpit; provide the program, its folder and the address of the page."""
    with tempfile.TemporaryDirectory() as name, isolated_ros_environment(name) as environment:
        command = [str(SRC.parents[1] / "drive"), "headless:=true", "cockpit:=true", *arguments]
        program = Program(command, environment, Path(name), Path(name) / "output.txt")
        try:
            yield program, Path(name), program.wait_for_match(r"cockpit: (http\S+)\s")
        finally:
            if program.process.poll() is None:
                program.interrupt()


def cpu_share(program, seconds):
    """Return the CPU time of the cockpit node, as a share of one core."""
    process = psutil.Process(program.pid_of("cockpit"))
    before, start_s = process.cpu_times(), time.monotonic()
    time.sleep(seconds)
    after = process.cpu_times()
    used_s = after.user + after.system - before.user - before.system
    return used_s / (time.monotonic() - start_s)


def measure_picture():
    with running_drive() as (_, _, address), headless_chromium() as browser:
        start_s = time.monotonic()
        browser.get(address)
        wait_for(browser, "window.cockpit && cockpit.picture.drawn > 0")
        print(f"first picture {time.monotonic() - start_s:.2f} s after opening the page")
        wait_for(browser, "cockpit.state && cockpit.state.speed > 2")
        browser.execute_script(
            "cockpit.picture.latencies.length = cockpit.picture.arrivals.length = 0"
        )
        start_s, before = time.monotonic(), value_of(browser, "cockpit.picture.drawn")
        time.sleep(SECONDS)
        drawn = value_of(browser, "cockpit.picture.drawn") - before
        print(f"{drawn / (time.monotonic() - start_s):.1f} pictures per second")
        for end, name in (("received by the page", "arrivals"), ("drawn", "latencies")):
            latencies = value_of(browser, f"cockpit.picture.{name}")
            median, most = np.percentile(latencies, [50, 95])
            print(f"stamp to {end}: median {median:.0f} ms, 95 % within {most:.0f} ms")


async def view(address, pictures):
    connection = await tornado.websocket.websocket_connect(
        address.replace("http", "ws", 1).replace("/?", "/ws?")
    )
    while True:
        message = await connection.read_message()
        if message is None:
            return
        if isinstance(message, bytes):
            kind, number, *_ = read_picture(message)
            if kind == CAMERA:
                pictures.value += 1
                await connection.write_message(json.dumps({"type": "drawn", "picture": number}))


async def view_many(address, count, pictures):
    await asyncio.gather(*(view(address, pictures) for _ in range(count)))


def run_viewers(*arguments):
    asyncio.run(view_many(*arguments))


@contextlib.contextmanager
def viewers(address, count):
    """Run viewers in a process of their own; provide the number of pictures that all received."""
    pictures = multiprocessing.Value("q", 0)
    process = multiprocessing.Process(
        target=run_viewers, args=(address, count, pictures), daemon=True
    )
    process.start()
    try:
        yield pictures
    finally:
        process.terminate()
        process.join()


def measure_viewers():
    with running_drive() as (program, _, address):
        program.wait_for_output("cross-track error")
        print(f"no viewer: {100.0 * cpu_share(program, SECONDS):.1f} % of a core")
        for count in (1, VIEWERS):
            with viewers(address, count) as pictures:
                time.sleep(3.0)
                before, start_s = pictures.value, time.monotonic()
                share = cpu_share(program, SECONDS)
                rate = (pictures.value - before) / (time.monotonic() - start_s) / count
            print(
                f"viewers: {count}, {100.0 * share:.0f} % of a core, "
                f"{rate:.1f} pictures per second to each"
            )


def tick_ms(count):
    """Return the wall time per tick of a drive in lockstep with so many viewers [ms]."""
    route = f"waypoints_path:={SRC / LOCKSTEP_ROUTE}"
    with running_drive("sync:=true", route) as (program, folder, address):
        with viewers(address, count) if count else contextlib.nullcontext():
            program.wait_for_end()
        report = json.loads((folder / "report" / "report.json").read_text(encoding="utf-8"))
    return 1e3 * report["wall_duration_s"] / report["ticks"]


def measure_lockstep():
    ratios = []
    for _ in range(ROUNDS):
        alone, watched = tick_ms(0), tick_ms(1)
        ratios.append(alone / watched)
        print(f"lockstep: {alone:.2f} ms a tick, with a viewer {watched:.2f} ms")
    print(
        f"lockstep with a viewer: {100.0 * statistics.median(ratios):.0f} % of the speed (median)"
    )


MEASUREMENTS = {
    "picture": measure_picture,
    "viewers": measure_viewers,
    "lockstep": measure_lockstep,
}


def main():
    chosen = sys.argv[1:] or list(MEASUREMENTS)
    if set(chosen) - set(MEASUREMENTS):
        sys.exit(f"usage: benchmark_cockpit.py [{'] ['.join(MEASUREMENTS)}]")
    for name in chosen:
        MEASUREMENTS[name]()


if __name__ == "__main__":
    main()
