"""The time slider of report.html, in a browser and as data."""

import base64
import io
import json

import numpy as np
import pytest
from PIL import Image as Picture
from referee_rules import TICK_NS, with_route
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from sdc_common.planning.stop_line import GREEN, RED
from sdc_sim.evaluation.drive_evaluation import OBSTACLES, PATH, PICTURE
from sdc_sim.report.html_page import slider_data, write_html
from sdc_testing.chromium import check_page, headless_chromium, resize


def jpeg(level):
    file = io.BytesIO()
    Picture.new("RGB", (32, 24), (level, level, level)).save(file, "JPEG")
    return base64.b64encode(file.getvalue()).decode()


def driven(ticks=200):
    """Return a drive with 100 ticks at 10 m/s and then behind an obstacle; the light is red."""
    evaluator = with_route(length_m=300)
    evaluator.add("stop_lines", [(7, 150.0, 0.0, 1.75)])
    for tick in range(1, ticks + 1):
        evaluator.add("odometry", tick * TICK_NS, 0.5 * tick, 0.25, 0.0, 10.0)
        evaluator.add("command", tick * TICK_NS, 0.5, 0.0, -0.125)
        evaluator.add("planned", 10.0 if tick <= 100 else 4.0)
        if tick % 5 == 1:
            evaluator.add("reason", tick * TICK_NS, "cruise" if tick <= 100 else "obstacle")
            evaluator.add("detail", tick * TICK_NS, "" if tick <= 100 else "follows car 17")
        if tick % 20 == 1:
            x = 0.5 * tick
            evaluator.add("scene", PATH, None, [(x, 0.0, 10.0), (x + 25.0, 0.0, 8.0)])
            box = (9, 120.0, 0.0, 0.0, 4.0, 2.0)
            evaluator.add("scene", OBSTACLES, 0.05 * tick, [box])
            evaluator.add("scene", PICTURE, 0.05 * tick, jpeg(tick))
    evaluator.add("lights", 0, [(7, RED)])
    return evaluator


def columns_of(data):
    packed = data["ticks"].items()
    return {name: np.frombuffer(base64.b64decode(one), "<f4") for name, one in packed}


def test_data_hold_every_tick_and_what_was_around_the_car():
    data = json.loads(slider_data(driven().result()))
    columns = columns_of(data)
    assert {len(column) for column in columns.values()} == {200}
    assert columns["x_m"][99] == pytest.approx(50.0)
    assert columns["target_mps"][[98, 150]].tolist() == [10.0, 4.0]
    assert [reason[0] for reason in data["reasons"]] == ["cruise", "obstacle"]
    assert columns["reason"].tolist() == 100 * [0.0] + 100 * [1.0]
    assert len(data["paths"]) == len(data["pictures"]) == 10
    assert data["paths"][1] == [1.0, [[10.5, 0.0, 10.0], [35.5, 0.0, 8.0]]]
    assert data["obstacles"][1] == [1.0, [[9.0, 120.0, 0.0, 0.0, 4.0, 2.0]]]
    assert data["lines"] == {"7": [150.0, 0.0, 1.75]}
    assert data["lights"][-1][1] == {"7": RED}


def test_drive_of_a_stack_that_publishes_nothing_has_data_too():
    evaluator = with_route()
    evaluator.add("odometry", TICK_NS, 0.0, 0.0, 0.0, 0.0)
    data = json.loads(slider_data(evaluator.result()))
    columns = columns_of(data)
    assert columns["reason"].tolist() == [-1.0]
    assert np.isnan(columns["target_mps"]).all()
    assert np.isnan(columns["steer"]).all()
    assert data["reasons"] == data["pictures"] == data["obstacles"] == []


def test_names_of_another_stack_cannot_end_the_script_element():
    evaluator = driven(20)
    evaluator.add("reason", TICK_NS * 10, "</script><b>")
    assert "<" not in slider_data(evaluator.result())


@pytest.fixture(scope="module")
def browser():
    with headless_chromium() as browser:
        yield browser


@pytest.mark.slow(15)
def test_person_scrubs_to_a_tick_and_sees_the_reason(browser, tmp_path):
    page = tmp_path / "report.html"
    evaluator = driven()
    evaluator.add("lights", 0, [(7, GREEN)])
    write_html(str(page), evaluator.result())
    for width in (1280, 390):
        resize(browser, width, 844)
        browser.get(page.as_uri())
        slider = browser.find_element(By.ID, "tick")

        def text(name):
            return browser.find_element(By.ID, name).text

        def term(name):
            return next(line for line in text("terms").split("\n") if line.startswith(name))

        assert text("reason") == "cruise"
        first_picture = browser.find_element(By.ID, "picture").get_attribute("src")
        slider.send_keys(*3 * [Keys.ARROW_RIGHT])
        assert term("time") == "time 0.20 s"
        browser.find_element(By.XPATH, "//button[text()='obstacle']").click()
        slider.send_keys(Keys.ARROW_LEFT)
        assert (text("reason"), term("time")) == ("cruise", "time 5.00 s")
        slider.send_keys(Keys.ARROW_RIGHT)
        assert (text("reason"), term("time")) == ("obstacle", "time 5.05 s")
        meaning = "stops behind an obstacle, or follows it: follows car 17"
        assert text("reason-meaning") == meaning
        assert term("target speed") == "target speed 4.00 m/s"
        assert term("cross-track error") == "cross-track error 0.250 m"
        assert term("steer") == "steer -0.125"
        assert "camera at 5.05 s" in text("picture-box")
        assert browser.find_element(By.ID, "picture").get_attribute("src") != first_picture
        slider.send_keys(Keys.END)
        assert term("time") == "time 10.00 s"
        assert colour_at_the_car(browser) == [25, 60, 120]
        assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    assert browser.get_log("browser") == []
    check_page(browser, page.as_uri())


def colour_at_the_car(browser):
    return browser.execute_script(
        "const c = document.getElementById('scene');"
        "return [...c.getContext('2d').getImageData(c.width / 2, c.height * 0.72, 1, 1).data]"
    )[:3]
