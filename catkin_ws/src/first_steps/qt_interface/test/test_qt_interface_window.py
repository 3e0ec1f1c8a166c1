"""The window on a screen of its own, with a real mouse and keyboard."""

import math
import os
import sys
import time
from pathlib import Path

import pytest
import yaml

sys.path.insert(0, str(Path(__file__).resolve().parent))
from virtual_screen import VirtualScreen  # noqa: E402

CONFIG = Path(__file__).resolve().parents[1] / "config" / "qt_interface.yaml"
LIMIT_SECONDS = 30.0
ELLIPSE = [
    (i, 350.0 * math.cos(math.pi * i / 15), 150.0 * math.sin(math.pi * i / 15)) for i in range(30)
]


class Shown:
    """A window that is shown, the screen it is on, and the wishes it uttered."""

    def __init__(self, screen, application, window):
        self.screen, self.application, self.window, self.scene = (
            screen,
            application,
            window,
            window.scene,
        )
        self.wishes = []
        window.car_dragged.connect(lambda x, y: self.wishes.append(("drag", x, y)))
        window.waypoint_wished.connect(lambda x, y: self.wishes.append(("waypoint", x, y)))
        window.pause_wished.connect(lambda wish: self.wishes.append(("pause", wish)))
        window.reset_wished.connect(lambda: self.wishes.append(("reset",)))

    def wait_for(self, condition):
        """Lets Qt work until the condition holds."""
        end = time.monotonic() + LIMIT_SECONDS
        while not condition():
            assert time.monotonic() < end, (
                f"waited {LIMIT_SECONDS} s in vain; wishes so far: {self.wishes}"
            )
            self.application.processEvents()
            time.sleep(0.005)

    def pixel(self, x, y):
        """Where on the screen the field point is."""
        from PyQt5.QtCore import QPoint

        px, py = self.window.field.view.to_pixel(x, y)
        point = self.window.field.mapToGlobal(QPoint(round(px), round(py)))
        return point.x(), point.y()

    def picture(self):
        """What is on the screen, as a QImage."""
        self.window.next_frame()
        for _ in range(5):
            self.application.processEvents()
        return self.application.primaryScreen().grabWindow(0).toImage()

    def colour(self, x, y):
        """The colour on the screen at the field point, (red, green, blue)."""
        return self.picture().pixelColor(*self.pixel(x, y)).getRgb()[:3]


@pytest.fixture(scope="module")
def screen_and_application():
    screen = VirtualScreen()
    before = {name: os.environ.get(name) for name in ("DISPLAY", "QT_QPA_PLATFORM")}
    os.environ.update(DISPLAY=screen.display, QT_QPA_PLATFORM="xcb")
    from PyQt5 import sip
    from PyQt5.QtWidgets import QApplication

    application = QApplication(["test"])
    yield screen, application
    sip.delete(application)  # before its screen goes: a Qt without a screen ends the process
    screen.stop()
    for name, value in before.items():
        os.environ.pop(name) if value is None else os.environ.update({name: value})


@pytest.fixture
def shown(screen_and_application):
    from PyQt5 import sip

    from qt_interface.scene import Scene
    from qt_interface.settings import WorldSizes, read_settings
    from qt_interface.window import Window

    screen, application = screen_and_application
    scene = Scene(read_settings(yaml.safe_load(CONFIG.read_text())))
    scene.set_world(WorldSizes(800.0, 450.0, 20.0, 100.0, False), ELLIPSE)
    scene.set_car(0.0, 0.0, 0.0, 0.0)
    window = Window(scene)
    window.show()
    shown = Shown(screen, application, window)
    shown.wait_for(lambda: window.windowHandle() is not None and window.windowHandle().isExposed())
    screen.xdotool("windowfocus", int(window.winId()))
    shown.wait_for(window.isActiveWindow)
    yield shown
    window.close()
    sip.delete(window)


def test_click_wishes_for_a_waypoint_there(shown):
    shown.screen.click(*shown.pixel(-150.0, 80.0))
    shown.wait_for(lambda: shown.wishes)
    ((kind, x, y),) = shown.wishes
    assert kind == "waypoint"
    assert (x, y) == (pytest.approx(-150.0, abs=1.0), pytest.approx(80.0, abs=1.0))


def test_click_outside_the_walls_is_refused_with_a_word(shown):
    shown.screen.click(*shown.pixel(0.0, 245.0))
    shown.wait_for(lambda: "outside the walls" in shown.window.statusBar().currentMessage())
    assert shown.wishes == []


def test_dragging_the_square_carries_it_and_adds_no_waypoint(shown):
    shown.screen.xdotool("mousemove", *shown.pixel(0.0, 0.0), "mousedown", 1)
    shown.screen.xdotool("mousemove", *shown.pixel(60.0, 40.0))
    shown.wait_for(lambda: shown.wishes and shown.wishes[-1][1] == pytest.approx(60.0, abs=1.0))
    red, green, blue = shown.colour(60.0 - 8.0, 40.0 + 8.0)
    assert red > 180 and green < 90 and blue < 90, "the square is drawn where the mouse holds it"
    count = len(shown.wishes)
    shown.wait_for(lambda: len(shown.wishes) > count + 3)  # held still, it says so again and again
    shown.screen.xdotool("mousemove", *shown.pixel(120.0, -90.0), "mouseup", 1)
    shown.wait_for(lambda: shown.wishes[-1][1] == pytest.approx(120.0, abs=1.0))
    assert {wish[0] for wish in shown.wishes} == {"drag"}
    shown.wait_for(lambda: shown.window.field._held_car is None)


def test_wheel_zooms_around_the_mouse_and_f_shows_all_again(shown):
    view = shown.window.field.view
    target = shown.pixel(200.0, 100.0)
    shown.screen.click(*target, button=4)
    shown.wait_for(lambda: shown.window.field.view.scale > view.scale)
    assert shown.pixel(200.0, 100.0) == pytest.approx(target, abs=1)
    zoomed = shown.window.field.view
    shown.screen.click(*target, button=5)
    shown.screen.click(*target, button=5)
    shown.wait_for(lambda: shown.window.field.view.scale < zoomed.scale / 1.2)
    shown.screen.xdotool("key", "f")
    shown.wait_for(lambda: shown.window.field.view == view)
    assert shown.wishes == []


def test_dragging_the_floor_pans(shown):
    view = shown.window.field.view
    x, y = shown.pixel(-200.0, -60.0)
    shown.screen.xdotool("mousemove", x, y, "mousedown", 1)
    shown.screen.xdotool("mousemove", x + 50, y + 30)
    shown.wait_for(lambda: shown.window.field.view != view)
    shown.screen.xdotool("mouseup", 1)
    shown.wait_for(lambda: shown.window.field._press is None)
    assert shown.pixel(-200.0, -60.0) == pytest.approx((x + 50, y + 30), abs=1)
    assert shown.wishes == []


def test_space_pauses_and_goes_on_and_r_resets(shown):
    shown.screen.xdotool("key", "space")
    shown.wait_for(lambda: shown.wishes == [("pause", True)])
    shown.window.set_paused(True)
    shown.screen.xdotool("key", "space")
    shown.wait_for(lambda: shown.wishes[1:] == [("pause", False)])
    shown.screen.xdotool("key", "r")
    shown.wait_for(lambda: shown.wishes[2:] == [("reset",)])


@pytest.mark.parametrize("key", ["q", "Escape", "ctrl+q", "ctrl+w"])
def test_keys_that_close_the_window(shown, key):
    shown.screen.xdotool("key", key)
    shown.wait_for(lambda: not shown.window.isVisible())


def test_the_cross_closes_the_window(shown):
    shown.screen.press_close_button(int(shown.window.winId()))
    shown.wait_for(lambda: not shown.window.isVisible())


def test_what_is_known_is_on_the_screen(shown):
    from qt_interface import painting

    def is_near(colour, place):
        return all(abs(a - b) < 40 for a, b in zip(shown.colour(*place), colour.getRgb()[:3]))

    beside = 7.0  # u, beside a number but still on its disc
    assert is_near(painting.CAR, (-8.0, 8.0))
    assert is_near(painting.WAYPOINT, (350.0, beside))
    assert is_near(painting.WALL, (402.5, 100.0)) and is_near(painting.WALL, (100.0, -227.5))
    assert is_near(painting.FLOOR, (-220.0, 33.0))
    shown.scene.set_sensed([ELLIPSE[0]])
    assert is_near(painting.SENSED, (350.0, beside))
    shown.scene.set_target(ELLIPSE[15])
    scale = shown.window.field.view.scale
    assert is_near(painting.TARGET, (-350.0 + (painting.DISC_RADIUS + 5.0) / scale, 0.0))
    for step in range(60):
        shown.scene.set_car(2.0 * step, 1.0 * step, 0.5, float(step))
    red, green, blue = shown.colour(60.0, 30.0)
    assert red > 200 and green < 200 and blue < 200, "the trail"
    shown.window.clear_trail()
    assert shown.colour(60.0, 30.0)[1] > 220, "no trail any more"


def test_status_bar_tells_where_it_stands(shown):
    shown.scene.set_target(ELLIPSE[7])
    shown.window.update_status()
    texts = " | ".join(label.text() for label in shown.window.labels.values())
    assert "30 waypoints, 0 sensed, heading for 7" in texts and "no car on /car_position" in texts
    shown.window.set_car(10.0, 20.0, math.pi / 2)
    shown.window.update_status()
    assert "running" in shown.window.labels["state"].text()
    assert "x 10  y 20  90" in shown.window.labels["car"].text()


def test_a_hundred_thousand_positions_leave_a_bounded_trail(shown):
    for step in range(100000):
        shown.scene.set_car(
            300.0 * math.sin(0.01 * step), 100.0 * math.cos(0.01 * step), 0.0, float(step)
        )
    assert 9000 < len(shown.scene.trail) <= 10000
    shown.picture()


@pytest.mark.parametrize(
    "points",
    [
        [],
        [(0, 1.0, 1.0)],
        [(3, math.nan, 0.0), (3, 5.0, math.inf)],
        [(i, float(i % 300), float(i // 300)) for i in range(20000)],
        [(0, 9e9, -9e9), (1, 0.0, 0.0)],
        [(7, 0.0, 0.0)] * 5,
    ],
)
def test_odd_waypoints_make_a_sane_picture(shown, points):
    from qt_interface.settings import read_world_sizes

    sizes = read_world_sizes({"field_width": -3, "field_height": "tall", "sensor_range": math.nan})
    shown.scene.set_world(sizes, points)
    shown.scene.set_sensed(points[:3])
    shown.window.set_car(math.nan, 0.0, 0.0)
    shown.window.field.fit_view()
    assert not shown.picture().isNull()
    assert shown.scene.car == (0.0, 0.0, 0.0), "a position that is none is ignored"
