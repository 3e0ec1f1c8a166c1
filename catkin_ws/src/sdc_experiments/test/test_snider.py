"""Test the comparison in a short form: its courses, and how errors grow and rank."""

import math
from pathlib import Path

import pytest

from sdc_experiments.snider import page
from sdc_experiments.snider.courses import figure_eight, lane_change, road_course
from sdc_experiments.snider.methods import Method, own_name
from sdc_experiments.snider.study import (
    PAPER_M,
    SPEEDS_MPS,
    UNDERSTEERING,
    PeakErrors,
    all_drives,
    drive,
    snider_car,
    understeering,
)

pytestmark = pytest.mark.slow(10)

DOCS = Path(__file__).resolve().parents[4] / "docs"
STORED = page.from_json((DOCS / "controllers.json").read_text(encoding="utf-8"))
COURSES = {course.name: course for course in (lane_change(), figure_eight(), road_course())}
PAPER = list(PAPER_M["figure-eight"])
COMPENSATED = own_name("stanley_compensated")


@pytest.fixture(scope="module")
def peaks():
    """Drives of the understeering car: figure-eight at 10 and 20 m/s, lane change at 10 and 15."""
    car = {"car": understeering(snider_car()[0])}
    eight = all_drives(car, [COURSES["figure-eight"]], (10.0, 20.0))
    change = all_drives(car, [COURSES["lane change"]], (10.0, 15.0))
    return {key[1:]: one for key, one in {**eight, **change}.items()}


def test_page_shows_the_stored_peak_errors():
    text = (DOCS / "controllers.md").read_text(encoding="utf-8")
    assert text == page.updated(text, STORED), "run python3 -m sdc_experiments.snider"
    wrong = {**STORED, (UNDERSTEERING, "road course", COMPENSATED, 20.0): PeakErrors(0.0, math.inf)}
    assert "| **lost** |" in page.updated(text, wrong)


def test_stored_peak_errors_are_those_of_the_code(peaks):
    for key, one in peaks.items():
        expected = pytest.approx(one, rel=2e-3, abs=1e-5)
        assert STORED[(UNDERSTEERING, *key)] == expected, "run python3 -m sdc_experiments.snider"


@pytest.mark.parametrize("method", PAPER)
def test_errors_are_near_those_of_the_paper(peaks, method):
    for course, speeds in (("figure-eight", (10.0, 20.0)), ("lane change", (10.0, 15.0))):
        for speed in speeds:
            paper = PAPER_M[course][method][SPEEDS_MPS.index(speed)]
            if paper:
                assert 0.5 < peaks[course, method, speed].point_m / paper < 2.0, (course, speed)


def test_car_that_leaves_the_road_has_no_peak_error():
    car, _ = snider_car()
    straight = Method("straight on", 0.0, 0.05, lambda: lambda course, state, point: 0.0)
    assert drive(straight, COURSES["figure-eight"], 10.0, car) == (math.inf, math.inf)
    lost = {("car", "course", "method", 5.0): (math.inf, 0.25)}
    assert page.from_json(page.to_json(lost)) == lost
