"""Weather of the camera picture."""

import cv2
import numpy as np
import pytest

from sdc_common.configuration import node_config
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.road import Road
from sdc_sim.simulation.weather import CLEAR, Weather

pytestmark = pytest.mark.slow(6)

ROAD = Road(np.column_stack([np.arange(0.0, 120.0, 2.0), np.zeros(60)]))
# Rows of the road some 5 m and 25 m ahead; the right line is 1.75 m to the right.
NEAR, FAR = 350, 262


@pytest.fixture(scope="module")
def picture():
    cv2.setNumThreads(1)
    pictures = {}

    def render(weather):
        if weather not in pictures:
            pictures[weather] = Renderer(ROAD, weather=weather).render(20.0, 0.0, 0.0)[..., :3]
        return pictures[weather].astype(float)

    return render


def contrast(picture, row):
    """Return how much brighter the right line is than the road in a row."""
    gray = picture[row, 320:560].mean(axis=1)
    return gray.max() - np.median(gray)


def test_default_parameters_are_clear_weather():
    assert Weather(**node_config("sdc_sim", "sim")["weather"]) == CLEAR == Weather()


def test_fog_hides_distant_lines_and_not_near_ones(picture):
    fog = picture(Weather(fog_m=40.0))
    assert contrast(fog, FAR) < 0.35 * contrast(picture(CLEAR), FAR)
    assert contrast(fog, NEAR) > 0.5 * contrast(picture(CLEAR), NEAR)
    assert (
        np.ptp(fog[:80, :400].mean(axis=2)) < 30.0 < np.ptp(picture(CLEAR)[:80, :400].mean(axis=2))
    )


def test_worn_lines_lose_paint_and_the_road_does_not_change(picture):
    clear, worn = picture(CLEAR), picture(Weather(worn_lines=0.7))
    rows = range(300, 420)
    assert np.mean([contrast(worn, row) for row in rows]) < 0.7 * np.mean(
        [contrast(clear, row) for row in rows]
    )
    assert np.array_equal(worn[:200], clear[:200])
    assert np.array_equal(worn[300:, 300:330], clear[300:, 300:330])


def test_rain_has_streaks_that_depend_on_place_and_time_only(picture):
    weather = Weather(rain=1.0)
    renderer = Renderer(ROAD, weather=weather)
    again = renderer.render(20.0, 0.0, 0.0)[..., :3]
    assert np.array_equal(again, picture(weather))
    assert not np.array_equal(renderer.render(20.03, 0.0, 0.0)[..., :3], again)
    falling = [renderer.render(20.0, 0.0, 0.0, time_s=0.05 * n)[..., :3] for n in range(6)]
    assert not any(map(np.array_equal, falling, falling[1:]))
    assert np.array_equal(renderer.render(20.0, 0.0, 0.0, time_s=0.1)[..., :3], falling[2])
    assert picture(weather)[300:].mean() < 0.95 * picture(CLEAR)[300:].mean()


def test_low_sun_casts_long_dark_shadows():
    assert np.hypot(*Weather(low_sun=True).shadow_m_per_m) > 3.0
    assert Weather(low_sun=True).shade < 0.6 * CLEAR.shade
