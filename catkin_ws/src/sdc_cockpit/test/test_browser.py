"""The page in a real browser, on a real drive."""

import math
import subprocess
import sys
import time
from pathlib import Path

import pytest
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

from sdc_testing.chromium import LIMIT_S, check_page, headless_chromium, resize, value_of, wait_for

pytestmark = pytest.mark.slow(40)

PIXELS = """(() => {
  const canvas = document.getElementById("picture");
  return canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data
    .reduce((sum, value, i) => (31 * sum + value) >>> 0, 0);
})()"""
# Pixels with the colour of the lane mask over a dark road.
MASKED = """(() => {
  const canvas = document.getElementById("picture");
  const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  let count = 0;
  for (let i = 0; i < pixels.length; i += 4) count += pixels[i + 1] === 255 && pixels[i] < 240;
  return count;
})()"""
AHEAD_IN_BEND = """const { aheadOnPath } = await import("./static/picture.js");
const path = [...Array(26).keys()].map((i) => [20 * Math.sin(i / 20), 20 - 20 * Math.cos(i / 20)]);
const { x, y } = aheadOnPath([0, 0, 0], path, 20);
return [x, y];"""
PICTURE_TOP_WITHOUT_AND_WITH_NOTICE = """[true, false].map((hidden) => {
  document.getElementById("notice").hidden = hidden;
  return document.getElementById("picture").getBoundingClientRect().top;
})"""
CUT_NAMES = """[...document.querySelectorAll("#nodes td, #parameters label, nav button")]
  .filter((one) => one.checkVisibility() && one.scrollWidth > one.clientWidth && one.clientWidth)
  .map((one) => one.textContent)"""
BUTTONS = """[...document.querySelectorAll("nav button")]
  .filter((one) => one.checkVisibility()).map((one) => one.textContent)"""
FOCAL_PX, MOUNT_X_M, MOUNT_Z_M, PITCH_RAD = 320.0, 0.7, 1.7, math.radians(0.5)


def click_on_path(browser, ahead_m, held=Keys.NULL):
    """Click on the picture where it shows the planned path at a distance, with a held key."""
    state = value_of(browser, "cockpit.state")
    x, y, yaw = state["pose"]
    c, s = math.cos(yaw), math.sin(yaw)
    places = [
        (c * (px - x) + s * (py - y), c * (py - y) - s * (px - x)) for px, py, _ in state["path"]
    ]
    forward, left = min(places, key=lambda place: abs(place[0] - ahead_m))
    depth = forward - MOUNT_X_M
    down = FOCAL_PX * math.tan(math.atan2(MOUNT_Z_M, depth) - PITCH_RAD)
    canvas = browser.find_element("id", "picture")
    scale = canvas.size["width"] / (2.0 * FOCAL_PX)
    right = -FOCAL_PX * left / depth
    # Offsets count from the middle of the element.
    ActionChains(browser).key_down(held).move_to_element_with_offset(
        canvas, round(scale * right), round(scale * down)
    ).click().key_up(held).perform()


def drive_until(browser, key, condition):
    """Drive with a held key until a condition is met.

    On a busy machine the browser may be late with the controls, so that the car brakes and is given
    back: then take over again.
    """
    limit_s = time.monotonic() + LIMIT_S
    while not value_of(browser, f"cockpit.driving && {condition}"):
        assert time.monotonic() < limit_s, f"{condition}: {value_of(browser, 'cockpit.state')}"
        if not value_of(browser, "cockpit.driving"):
            ActionChains(browser).key_up(key).send_keys("p").key_down(key).perform()
        elif not value_of(browser, "cockpit.held.length"):
            ActionChains(browser).key_up(key).key_down(key).perform()
        time.sleep(0.1)  # The browser and the drive need the processor.
    ActionChains(browser).key_up(key).perform()


def set_parameter(browser, name, text):
    """Type a value into the field of a parameter, at once: the page refreshes the others."""
    field = f"""document.querySelector("#parameters [name='{name}']")"""
    wait_for(browser, f"{field} !== null")
    browser.execute_script(
        f"""{field}.value = "{text}"; {field}.dispatchEvent(new Event("change"));"""
    )


def test_page_shows_moving_pictures_and_drives_and_a_click_stops_the_car(start, tmp_path):
    route = tmp_path / "straight.csv"
    route.write_text("".join(f"{x},0\n" for x in range(5000)))
    # On a busy machine each command to the browser takes seconds, and the car drives or stands on
    # meanwhile: a slow car does not get far, and the referee waits.
    late_page = str(Path(__file__).with_name("late_page.launch"))
    launch = [sys.executable, "-m", "sdc_sim.ros.safe_launch", "sdc_package", "all.launch"]
    options = ["headless:=true", "cockpit:=true", "planned_speed_mps:=2"]
    options += [f"waypoints_path:={route}", f"report:={tmp_path}/report.json"]
    options += ["referee_options:={pictures: false, blocked_s: 1000}"]
    drive, address = start(*launch, late_page, *options)
    # The processor draws each pixel of the page.
    with headless_chromium(640, 480) as browser:
        browser.get(address)
        wait_for(browser, "window.cockpit && cockpit.picture.drawn > 0")
        wait_for(browser, "cockpit.state && cockpit.state.speed > 1")
        first = value_of(browser, PIXELS)
        wait_for(browser, PIXELS, lambda pixels: pixels != first)
        wait_for(browser, "document.querySelectorAll('#nodes tr.topic').length")

        assert browser.execute_script(AHEAD_IN_BEND) == pytest.approx([16.83, 9.19], abs=0.01)
        browser.find_element("id", "mask").click()
        wait_for(browser, MASKED, lambda count: count > 100)
        browser.find_element("id", "mask").click()
        wait_for(browser, MASKED, lambda count: count < 100)

        badge = "document.getElementById('driver').textContent"
        drive_until(browser, "s", f"{badge} === 'you drive' && cockpit.state.command.brake === 1")
        drive_until(browser, "s", "cockpit.state.speed < 0.05")
        drive_until(browser, "w", "cockpit.state.command.throttle > 0.5 && cockpit.state.speed > 1")
        drive_until(browser, "s", "cockpit.state.speed < 0.05")

        goal = ["rostopic", "echo", "-n", "1", "-p", "/move_base_simple/goal/pose/position"]
        with subprocess.Popen(goal, env=drive.environment, stdout=subprocess.PIPE) as echo:
            while echo.poll() is None:
                click_on_path(browser, 25.0, Keys.SHIFT)
                time.sleep(0.5)
            assert b"field.x,field.y" in echo.stdout.read()
        assert value_of(browser, "cockpit.state.obstacles") == []

        click_on_path(browser, 25.0)
        obstacle = wait_for(browser, "cockpit.state.obstacles[0]")["box"]
        start_m = value_of(browser, "cockpit.state.pose")[:2]
        ActionChains(browser).send_keys(Keys.ESCAPE).perform()
        wait_for(browser, "cockpit.state.mode === 'stack'")

        def has_driven_to_obstacle(state):
            driven_m = math.dist(state["pose"][:2], start_m)
            distance_m = math.dist(state["pose"][:2], obstacle[:2])
            at_rest = state["running"] and state["speed"] < 0.05
            return at_rest and driven_m > 1.0 and 2.0 < distance_m < 15.0

        wait_for(browser, "cockpit.state", has_driven_to_obstacle)

        notice = "document.getElementById('notice').textContent"
        set_parameter(browser, "/sim/friction", "-1")
        wait_for(browser, notice, lambda text: "friction must be a number from" in text)
        set_parameter(browser, "/sim/friction", "0.4")
        wait_for(browser, notice, lambda text: text == "/sim/friction is 0.4")
        # A click must hit the place at which the person aims.
        without, with_notice = value_of(browser, PICTURE_TOP_WITHOUT_AND_WITH_NOTICE)
        assert without == with_notice
        for width, touch in ((1280, False), (390, True)):
            resize(browser, width, 800, touch)
            assert value_of(browser, "document.documentElement.scrollWidth") <= width
            assert value_of(browser, CUT_NAMES) == []
            assert ("Keys" in value_of(browser, BUTTONS)) is not touch
        check_page(browser, address)
