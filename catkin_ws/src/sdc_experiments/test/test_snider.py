"""Test the comparison in a short form: its courses, and how errors grow and rank."""

import math
from pathlib import Path

import pytest

from sdc_experiments.snider import report
from sdc_experiments.snider.courses import figure_eight, lane_change, road_course
from sdc_experiments.snider.methods import Method, own_name
from sdc_experiments.snider.study import (
    PAPER_M,
    SPEEDS_MPS,
    UNDERSTEERING,
    all_drives,
    drive,
    snider_car,
    understeering,
)

pytestmark = pytest.mark.slow(10)

DOCS = Path(__file__).resolve().parents[4] / "docs"
STORED = report.from_json((DOCS / "controllers.json").read_text(encoding="utf-8"))
COURSES = {course.name: course for course in (lane_change(), figure_eight(), road_course())}
PAPER = list(PAPER_M["figure-eight"])
TEXTBOOK, COMPENSATED = own_name("stanley"), own_name("stanley_compensated")


@pytest.fixture(scope="module")
def peaks():
    """Drives of the understeering car: figure-eight at 10 and 20 m/s, lane change at 10 and 15."""
    car = {"car": understeering(snider_car()[0])}
    eight = all_drives(car, [COURSES["figure-eight"]], (10.0, 20.0))
    change = all_drives(car, [COURSES["lane change"]], (10.0, 15.0))
    return {key[1:]: trace for key, trace in {**eight, **change}.items()}


def test_page_shows_the_stored_peak_errors():
    page = (DOCS / "controllers.md").read_text(encoding="utf-8")
    assert page == report.page(STORED), "run python3 -m sdc_experiments.snider"


def test_stored_peak_errors_are_those_of_the_code(peaks):
    for key, trace in peaks.items():
        expected = pytest.approx((trace.peak_m, trace.centre_peak_m), rel=2e-3, abs=1e-5)
        assert STORED[(UNDERSTEERING, *key)] == expected, "run python3 -m sdc_experiments.snider"


@pytest.mark.parametrize("method", PAPER)
def test_errors_are_near_those_of_the_paper(peaks, method):
    for course, speeds in (("figure-eight", (10.0, 20.0)), ("lane change", (10.0, 15.0))):
        for speed in speeds:
            paper = PAPER_M[course][method][SPEEDS_MPS.index(speed)]
            if paper:
                assert 0.5 < peaks[course, method, speed].peak_m / paper < 2.0, (course, speed)


def test_car_that_leaves_the_road_is_reported_as_lost():
    assert report.metres(math.inf) == "lost"
    car, _ = snider_car()
    straight = Method("straight on", 0.0, 0.05, lambda: lambda course, state, near: 0.0)
    trace = drive(straight, COURSES["figure-eight"], 10.0, car)
    assert not trace.finished
    assert trace.peak_m == math.inf
    lost = {("car", "course", "method", 5.0): report.PeakErrors(math.inf, 0.25)}
    assert report.from_json(report.to_json(lost)) == lost
