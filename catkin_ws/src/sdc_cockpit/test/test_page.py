"""The page in a real browser, with the messages of a drive from a table."""

import asyncio
import contextlib
import threading
from pathlib import Path

import pytest
import tornado.httpserver
import tornado.ioloop

from sdc_cockpit import server
from sdc_cockpit.access import Access
from sdc_cockpit.drive_arguments import form_fields
from sdc_cockpit.drive_view import DriveView
from sdc_cockpit.protocol import json_message
from sdc_cockpit.viewers import Viewers
from sdc_testing.chromium import headless_chromium, value_of, wait_for

pytestmark = pytest.mark.slow(5)

WWW = Path(__file__).parents[1] / "www"
NOTHING = {**DriveView(float, float).state(), "mode": "stack", "driver": None, "phase": None}
MOVING = {**NOTHING, "t": 5.0, "running": True, "pose": [0, 0, 0], "speed": 9.0, "progress": 0.64}
WAITING = {**MOVING, "reason": "stops behind an obstacle, or follows it: car 102"}
ROW = {"name": "d", "key": "k", "page": True, "problem": "", "exit_status": 0, "arguments": []}
ROW.update(status="completed", route_completion_percent=100.0, duration_s=27.9)
ROW.update(cross_track_rms_m=0.1, driving_score=100.0)
LIMIT = "missed_ticks is 4, at most 0 is allowed"
# What differs in the row of the drive, and the banner.
ENDS = [
    ({}, "Completed at 100 %: 27.9 s, driving score 100. Open report"),
    ({"exit_status": 1, "problem": LIMIT}, f"Completed at 100 %: {LIMIT}. Open report"),
    (
        {"exit_status": 1, "status": "blocked", "route_completion_percent": 64.2},
        f"Blocked at 64 %: {WAITING['reason']}. Open report",
    ),
    (
        {"exit_status": 130, "status": "off_route", "route_completion_percent": 3.0},
        "Off route at 3 %. Open report",
    ),
    (
        {"exit_status": 2, "status": None, "page": False, "problem": "no such map"},
        "Failed, without a report: no such map. Open log",
    ),
]
SHOWN = """[...document.querySelectorAll("header :is(button, select)")]
  .filter((one) => one.checkVisibility()).map((one) => one.textContent || one.name)"""


class Backend:
    """Records what a page sends; the road cannot be read."""

    def __init__(self):
        self.viewers, self.received, self.hello = Viewers(), [], threading.Event()

    def joined(self, viewer):
        fields = {"scenario": {"enum": ["oval"]}, **form_fields()}
        scale = {"full_speed": 10.0, "speed_colours": [[0, 0, 0]] * 3}
        viewer.send(json_message("hello", viewer=1, log=[], fields=fields, **scale))
        self.hello.set()

    def left(self, viewer):
        pass

    def receive(self, viewer, message):
        self.received.append(message)

    def road_json(self):
        raise ValueError("this map is broken")

    def send(self, kind, **values):
        """Send a message to the page."""
        message = json_message(kind, **values)
        self.loop.add_callback(self.viewers.broadcast, message, True)

    def send_drives(self, state, running=None, **row):
        """Send the list of drives, the last one of which differs from ROW, and the state."""
        self.send("drives", offered=True, running=running, ended="d", past=[{**ROW, **row}])
        self.send("state", **state)

    def serve(self, sockets):
        """Serve the page until the loop is stopped."""
        asyncio.set_event_loop(asyncio.new_event_loop())
        self.loop = tornado.ioloop.IOLoop.current()
        application = server.application(self, Access("secret", loopback=True), WWW)
        tornado.httpserver.HTTPServer(application).add_sockets(sockets)
        self.loop.start()


@contextlib.contextmanager
def page_of(backend):
    sockets, port = server.bind("127.0.0.1", 18300)
    thread = threading.Thread(target=backend.serve, args=(sockets,))
    thread.start()
    try:
        with headless_chromium(1440, 900) as browser:
            browser.get(server.page_address("127.0.0.1", port, "secret"))
            assert backend.hello.wait(60.0)
            yield browser
    finally:
        backend.loop.add_callback(backend.loop.stop)
        thread.join()


def text_of(name):
    return f"document.getElementById('{name}').innerText"


def test_page_shows_start_phases_and_the_end_of_a_drive():
    backend = Backend()
    with page_of(backend) as browser:
        backend.send_drives(NOTHING)
        wait_for(browser, f"{SHOWN}.includes('Start')")
        shown = value_of(browser, SHOWN)
        assert shown[2:] == ["Start", "Drives", "Keys"] and "oval" in shown[0]
        limits = form_fields()["planned_speed_mps"]
        speed = "document.querySelector('#start-form [name=planned_speed_mps]')"
        shown = [value_of(browser, f"{speed}.{name}") for name in ("min", "max", "title")]
        assert shown == [str(limits["minimum"]), str(limits["maximum"]), limits["about"]]
        browser.find_element("id", "start").click()
        wait_for(
            browser,
            "true",
            lambda _: (
                ("start", "")
                in [(kind, values.get("scenario")) for kind, values in backend.received]
            ),
        )

        backend.send_drives({**NOTHING, "phase": "compiling: 36 %"}, running="x")
        wait_for(browser, text_of("status"), lambda text: text == "starting compiling: 36 %")
        assert value_of(browser, text_of("no-picture")) == "compiling: 36 %"
        shown = value_of(browser, SHOWN)
        assert shown[0] == "Stop" and "Start" not in shown
        backend.send_drives(MOVING, running="x")
        wait_for(
            browser, text_of("no-picture"), lambda text: text == "waiting for the first picture"
        )
        backend.send_drives({**WAITING, "phase": "writing the report"}, running="x")
        over = "the drive is over writing the report"
        wait_for(browser, text_of("status"), lambda text: text == over)
        for row, banner in ENDS:
            backend.send_drives(WAITING, **row)
            wait_for(browser, text_of("end"), lambda text, banner=banner: text == banner)
            assert value_of(browser, "document.getElementById('end').className") == (
                "bad" if row else "good"
            )

        backend.send("ended", report="/tmp/report.json", **ROW)
        wait_for(browser, text_of("end"), lambda text: text.endswith("Report: /tmp/report.json"))
        backend.send("state", **{**MOVING, "road": 1})
        notice = "document.getElementById('notice').textContent"
        wait_for(browser, notice, lambda text: text.startswith("3D view: "))
        backend.send("nodes", nodes=None)
        wait_for(browser, notice, lambda text: text.startswith("This page: "))
