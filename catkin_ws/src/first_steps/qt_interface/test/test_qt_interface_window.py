"""Test the window on a virtual display, with its mouse and keyboard."""

import math
import os
import sys
import time
from pathlib import Path

import pytest
import yaml

sys.path.insert(0, str(Path(__file__).resolve().parent))
from window_control import qt_display  # noqa: E402

from qt_interface.field import Point  # noqa: E402

CONFIG = Path(__file__).resolve().parents[1] / "config" / "qt_interface.yaml"
LIMIT_SECONDS = 30.0
ELLIPSE = [
    Point(i, 350.0 * math.cos(math.pi * i / 15), 150.0 * math.sin(math.pi * i / 15))
    for i in range(30)
]


class Shown:
    """A visible window, its display, and the requests that the window emitted."""

    def __init__(self, display, application, window):
        self.display, self.application = display, application
        self.window, self.field = window, window.field
        self.click, self.xdotool = display.click, display.xdotool
        self.requests = []
        self.field.car_dragged.connect(lambda x, y: self.requests.append(("drag", x, y)))
        self.field.waypoint_requested.connect(lambda x, y: self.requests.append(("waypoint", x, y)))
        window.pause_requested.connect(lambda pause: self.requests.append(("pause", pause)))
        window.reset_requested.connect(lambda: self.requests.append(("reset",)))

    def wait_for(self, condition):
        """Run Qt's event loop until the condition holds."""
        end = time.monotonic() + LIMIT_SECONDS
        while not condition():
            assert time.monotonic() < end, (
                f"timeout after {LIMIT_SECONDS} s; requests: {self.requests}"
            )
            self.application.processEvents()
            time.sleep(0.005)

    def pixel(self, x, y):
        """Return the pixel of the display that shows the field point."""
        point = self.field.mapToGlobal(self.field.mapFromScene(x, y))
        return point.x(), point.y()

    def picture(self):
        """Return the content of the display as a QImage."""
        self.field.next_frame()
        for _ in range(5):
            self.application.processEvents()
        return self.application.primaryScreen().grabWindow(0).toImage()

    def colour(self, x, y):
        """Return the displayed colour at the field point, (red, green, blue)."""
        return self.picture().pixelColor(*self.pixel(x, y)).getRgb()[:3]


@pytest.fixture(scope="module")
def display_and_application():
    before = {name: os.environ.get(name) for name in ("DISPLAY", "QT_QPA_PLATFORM")}
    with qt_display() as display:
        os.environ.update({name: display.environment[name] for name in before})
        from PyQt5 import sip
        from PyQt5.QtWidgets import QApplication

        application = QApplication(["test"])
        yield display, application
        # Delete the application first: Qt ends the process when its display disappears.
        sip.delete(application)
    for name, value in before.items():
        os.environ.pop(name) if value is None else os.environ.update({name: value})


@pytest.fixture
def shown(display_and_application):
    from PyQt5 import sip

    from qt_interface.settings import WorldSizes, read_settings
    from qt_interface.window import Window

    display, application = display_and_application
    window = Window(read_settings(yaml.safe_load(CONFIG.read_text())))
    window.field.set_world(WorldSizes(800.0, 450.0, 20.0, 100.0, False), ELLIPSE)
    window.field.set_car(0.0, 0.0, 0.0)
    window.show()
    shown = Shown(display, application, window)
    shown.wait_for(lambda: window.windowHandle() is not None and window.windowHandle().isExposed())
    shown.xdotool("windowfocus", int(window.winId()))
    shown.wait_for(window.isActiveWindow)
    yield shown
    window.close()
    sip.delete(window)


def test_click_requests_a_waypoint_there(shown):
    shown.click(*shown.pixel(200.0, 80.0), button=3)
    shown.click(*shown.pixel(-150.0, 80.0))
    shown.wait_for(lambda: shown.requests)
    ((kind, x, y),) = shown.requests
    assert kind == "waypoint"
    assert (x, y) == (pytest.approx(-150.0, abs=1.0), pytest.approx(80.0, abs=1.0))


def test_click_outside_the_walls_is_refused_with_a_message(shown):
    shown.click(*shown.pixel(0.0, 245.0))
    shown.wait_for(lambda: "outside the walls" in shown.window.statusBar().currentMessage())
    assert shown.requests == []


def test_drag_of_the_square_carries_it_and_adds_no_waypoint(shown):
    shown.field.zoom_by(1.1)
    shown.xdotool("mousemove", *shown.pixel(0.0, 0.0), "mousedown", 1)
    shown.xdotool("mousemove", *shown.pixel(60.0, 40.0))
    shown.wait_for(lambda: shown.requests and shown.requests[-1][1] == pytest.approx(60.0, abs=1.0))
    shown.window.set_car(0.0, 0.0, 0.0)  # the world has not moved it yet
    red, green, blue = shown.colour(60.0 - 8.0, 40.0 + 8.0)
    assert red > 180 and green < 90 and blue < 90, "the square is drawn where the mouse holds it"
    count = len(shown.requests)
    shown.wait_for(lambda: len(shown.requests) > count + 3)  # a held car is requested repeatedly
    shown.xdotool("mousemove", *shown.pixel(120.0, -90.0), "mouseup", 1)
    shown.wait_for(lambda: shown.requests[-1][1] == pytest.approx(120.0, abs=1.0))
    assert {request[0] for request in shown.requests} == {"drag"}
    shown.wait_for(lambda: not shown.field.is_car_held)


def test_wheel_zooms_around_the_mouse_and_f_shows_all(shown):
    view = shown.field.viewportTransform()
    target = shown.pixel(200.0, 100.0)
    shown.click(*target, button=4)
    shown.wait_for(lambda: shown.field.zoom > view.m11())
    assert shown.pixel(200.0, 100.0) == pytest.approx(target, abs=1)
    zoomed = shown.field.zoom
    shown.click(*target, button=5)
    shown.click(*target, button=5)
    shown.wait_for(lambda: shown.field.zoom < zoomed / 1.2)
    shown.xdotool("key", "f")
    shown.wait_for(lambda: shown.field.viewportTransform() == view)
    assert shown.requests == []


def test_drag_of_the_floor_pans(shown):
    view = shown.field.viewportTransform()
    x, y = shown.pixel(-200.0, -60.0)
    shown.xdotool("mousemove", x, y, "mousedown", 1)
    shown.xdotool("mousemove", x + 50, y + 30)
    shown.wait_for(lambda: shown.field.viewportTransform() != view)
    shown.xdotool("mouseup", 1)
    shown.wait_for(lambda: shown.pixel(-200.0, -60.0) != (x, y))
    assert shown.pixel(-200.0, -60.0) == pytest.approx((x + 50, y + 30), abs=1)
    assert shown.requests == []


@pytest.mark.parametrize("key", ["q", "Escape", "ctrl+q", "ctrl+w"])
def test_key_closes_the_window(shown, key):
    shown.xdotool("key", key)
    shown.wait_for(lambda: not shown.window.isVisible())


def test_scene_is_visible_on_the_display(shown):
    from qt_interface import field

    def is_near(colour, place):
        return all(abs(a - b) < 40 for a, b in zip(shown.colour(*place), colour.getRgb()[:3]))

    off_centre = 7.0  # u, next to the number but still on the disc
    assert is_near(field.CAR, (-8.0, 8.0))
    assert is_near(field.WAYPOINT, (350.0, off_centre))
    assert is_near(field.WALL, (402.5, 100.0)) and is_near(field.WALL, (100.0, -227.5))
    assert is_near(field.FLOOR, (-220.0, 33.0))
    shown.field.set_sensed([ELLIPSE[0]])
    assert is_near(field.SENSED, (350.0, off_centre))
    shown.field.set_target(ELLIPSE[15])
    scale = shown.field.zoom
    assert is_near(field.TARGET, (-350.0 + (field.DISC_RADIUS + 5.0) / scale, 0.0))
    for step in range(60):
        shown.field.set_car(2.0 * step, 1.0 * step, 0.5)
    red, green, blue = shown.colour(60.0, 30.0)
    assert red > 200 and green < 200 and blue < 200, "the trail"
    shown.field.trail.clear()
    assert shown.colour(60.0, 30.0)[1] > 220, "the trail is removed"


@pytest.mark.parametrize("degrees", [0.0, 40.0, 90.0, 200.0])
def test_square_points_in_the_direction_of_the_car(shown, degrees):
    angle = math.radians(degrees)
    shown.field.set_world(shown.field.sizes._replace(car_size=20.0, sensor_range=None), [])
    shown.field.set_car(0.0, 0.0, angle)
    picture = shown.picture()

    def redness(direction):
        x, y = shown.pixel(18.0 * math.cos(direction), 18.0 * math.sin(direction))
        near = [picture.pixelColor(x + i, y + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        return max(colour.red() - colour.green() for colour in near)

    nose, *others = (redness(angle + turn * math.pi / 4.0) for turn in range(8))
    assert nose > 40 and max(others) < 20, "only the nose reaches out of the square"


def test_legend_shows_the_laps_and_each_symbol_in_its_colour(shown):
    from qt_interface.legend import SYMBOLS

    shown.window.legend.set_laps(7)
    assert ">7<" in shown.window.legend.text()
    picture = shown.window.legend.grab().toImage()
    pixels = {picture.pixel(x, y) for x in range(picture.width()) for y in range(picture.height())}
    for _, colour, name in SYMBOLS:
        assert colour.rgb() in pixels, name


def test_trail_keeps_the_newest_steps_without_jumps(shown):
    newest = shown.field.trail.maxlen
    for x in range(newest + 50):
        shown.field.set_car(float(x), 0.0, 0.0)
    shown.field.set_car(-300.0, 0.0, 0.0)
    assert [(step.x1(), step.x2()) for step in shown.field.trail] == [
        (x, x + 1) for x in range(49, newest + 49)
    ]


def test_field_without_sizes_has_no_walls_and_shows_the_way_of_the_car(shown):
    from PyQt5.QtCore import QRectF

    from qt_interface.settings import WorldSizes

    shown.field.set_world(WorldSizes(), [Point(1, 5.0, 6.0)])
    for x, y in ((1.0, 2.0), (-1.0, 9.0)):
        shown.field.set_car(x, y, 0.0)
    assert shown.field.walls is None
    assert shown.field.extent() == QRectF(-1.0, 0.0, 6.0, 9.0)
    shown.click(*shown.pixel(-8.0, 8.0))
    shown.wait_for(lambda: shown.requests)


def test_status_bar_shows_state_car_and_waypoints(shown):
    shown.field.set_target(ELLIPSE[7])
    shown.window.update_status()
    texts = shown.window.status.text()
    assert "30 waypoints, 0 sensed, heading for 7" in texts and "no car on /car_position" in texts
    shown.window.set_car(10.0, 20.0, math.pi / 2)
    shown.window.update_status()
    texts = shown.window.status.text()
    assert "running" in texts and "car x 10  y 20  90" in texts
