"""The cockpit on real drives, without a browser: a vanished driver, and drives from the page."""

import asyncio
import json
import os
import subprocess
import urllib.request
from pathlib import Path

import cv2
import numpy as np
import pytest
import tornado.websocket
from page_messages import read_picture

from sdc_cockpit.protocol import LANE_OVERLAY

ROOT = Path(__file__).resolve().parents[4]
SHORT = {"camera": False, "sync": True}


class Page:
    """A page without a browser."""

    def __init__(self, connection):
        self.connection = connection

    @classmethod
    async def open(cls, address):
        socket = address.replace("http", "ws", 1).replace("/?", "/ws?")
        return cls(await tornado.websocket.websocket_connect(socket))

    async def send(self, kind, **values):
        await self.connection.write_message(json.dumps({"type": kind, **values}))

    async def next(self, kind, accepts=lambda values: True, before_each=None):
        """Return the next message of a kind that is accepted."""
        while True:
            if before_each is not None:
                await before_each()
            message = await self.connection.read_message()
            assert message is not None, "the server closed the connection"
            if isinstance(message, str):
                values = json.loads(message)
                if values["type"] == kind and accepts(values):
                    return values


def throttle_of(state):
    """Return the throttle that the car obeys, None before its first status."""
    return state["command"] and state["command"]["throttle"]


async def drive_and_vanish(address):
    """Drive with full throttle, then send nothing; return the simulated times and the modes."""
    watcher, person = await Page.open(address), await Page.open(address)

    async def throttle():
        await person.send("keys", held=["w"])

    await watcher.next("state", lambda state: state["speed"] and state["speed"] > 1.0)
    await person.send("drive")
    is_driven = lambda state: state["mode"] == "person" and throttle_of(state) == 1.0  # noqa: E731
    await watcher.next("state", is_driven, throttle)
    # The connection stays open without controls, as that of a laptop that sleeps.
    vanished = await watcher.next("state")
    braked = await watcher.next("state", lambda state: state["command"]["brake"] == 1.0)
    returned = await watcher.next("state", lambda state: state["mode"] != "braking")
    await watcher.next("state", lambda state: state["command"]["throttle"] > 0.0)
    return braked["t"] - vanished["t"], braked["mode"], returned["mode"]


@pytest.mark.nightly
@pytest.mark.slow(20)
def test_driver_that_vanishes_brakes_the_car_and_returns_it(drive):
    _, address = drive("camera:=false", "referee_options:={pictures: false}")
    seconds, braking, returned = asyncio.run(drive_and_vanish(address))
    assert seconds <= 2.0, "of simulated time"
    assert (braking, returned) == ("braking", "stack")


async def overlay_of(address):
    """Return the kind and the pixels of the first picture for a page that shows the lane mask."""
    page = await Page.open(address)
    await page.send("show", mask=True)
    while True:
        message = await page.connection.read_message()
        assert message is not None, "the server closed the connection"
        if isinstance(message, bytes):
            kind, _, _, _, file = read_picture(message)
            return kind, cv2.imdecode(np.frombuffer(file, np.uint8), cv2.IMREAD_COLOR)


@pytest.mark.nightly
@pytest.mark.slow(5)
def test_page_with_the_lane_mask_gets_the_overlay_of_the_lab_on_perception(start):
    program, address = start(str(ROOT / "cockpit"))
    pixels = ", ".join(64 * ["0, 0, 255"])
    red = f"{{height: 8, width: 8, encoding: bgr8, step: 24, data: [{pixels}]}}"
    command = ["rostopic", "pub", "-r10", "/perception/lane_overlay", "sensor_msgs/Image", red]
    publisher = subprocess.Popen(command, env=program.environment)
    try:
        kind, picture = asyncio.run(asyncio.wait_for(overlay_of(address), 120.0))
    finally:
        publisher.terminate()
        publisher.wait()
    assert kind == LANE_OVERLAY
    assert (picture[..., 2] > 200).all()
    assert (picture[..., :2] < 50).all()


async def start_stop_and_fail(address):
    """Complete a drive, stop another one; return what the page shows of both."""
    page = await Page.open(address)
    assert (await page.next("drives"))["offered"]
    await page.send("start", scenario="slalom", arguments=SHORT)
    assert (await page.next("drives", lambda drives: drives["running"]))["past"] == []
    first = await page.next("drives", lambda drives: drives["running"] is None)

    await page.send("start", scenario="oval", arguments={"camera": False, "friction": 0.8})
    # The state of the first drive is gone: this is the second one.
    begins = lambda state: state["t"] and state["t"] < 15.0 and state["speed"] > 1.0  # noqa: E731
    await page.next("state", begins)
    values = await page.next("parameters", lambda message: "/sim/friction" in message["values"])
    assert values["values"]["/sim/friction"] == 0.8
    await page.send("start", scenario="", arguments={})
    await page.next("notice", lambda notice: "stop it first" in notice["text"])
    await page.send("stop")
    second = await page.next("drives", lambda drives: drives["running"] is None)
    return first["past"], second["past"]


def answer(address, path, **query):
    base, token = address.split("/?")
    words = "&".join([token, *(f"{name}={value}" for name, value in query.items())])
    with urllib.request.urlopen(f"{base}/{path}?{words}") as response:
        return response.read().decode()


@pytest.mark.slow(40)
def test_page_starts_stops_lists_and_compares_drives(standing_cockpit):
    address = standing_cockpit()
    first, second = asyncio.run(start_stop_and_fail(address))
    assert [(row["status"], row["exit_status"]) for row in first] == [("completed", 0)]
    assert [row["status"] for row in second] == ["aborted", "completed"]
    assert second[0]["name"].endswith("-oval")
    assert "scenario:=oval" in second[0]["arguments"]
    names = [row["name"] for row in second]
    key = second[1]["key"]
    assert "completed" in answer(address, f"drives/{names[1]}/report.html", key=key)
    compared = json.loads(answer(address, "api/compare", a=names[0], b=names[1]))
    assert "route_completion_percent" in compared["text"]
    assert compared["picture"].startswith("data:image/png;base64,")


@pytest.mark.slow(8)
@pytest.mark.parametrize(
    ("display", "arguments", "served"),
    [("", [], True), ("", ["sync:=true"], False), (":0", [], False)],
)
def test_cockpit_is_the_default_without_a_display(display, arguments, served, tmp_path):
    # roslaunch only lists the nodes that it would start.
    command = [str(ROOT / "drive"), *arguments, "--nodes"]
    environment = {**os.environ, "DISPLAY": display, "PWD": str(tmp_path)}
    place = {"cwd": tmp_path, "env": environment}
    listed = subprocess.run(command, capture_output=True, text=True, check=False, **place)
    assert "/referee" in listed.stdout.split(), listed.stderr
    assert ("/cockpit" in listed.stdout.split()) == served
