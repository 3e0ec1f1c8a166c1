"""The paper's courses in a short form: the courses are what they say, and the methods' errors grow and rank as in the paper."""

import math

import pytest

from sdc_experiments import snider, snider_report
from sdc_experiments.snider import PAPER_M, SPEEDS_MPS

COURSES = {
    course.name: course
    for course in (snider.lane_change(), snider.figure_eight(), snider.road_course())
}
PAPER = list(PAPER_M["figure-eight"])
OURS = snider_report.OURS


@pytest.fixture(scope="module")
def peaks():
    """Peak error of each method on the figure-eight at 10 and 20 m/s and in the lane change at 10 and 15, with the understeering car."""
    car = {"car": snider.understeering(snider.snider_car()[0])}
    eight = snider.all_drives(car, [COURSES["figure-eight"]], (10.0, 20.0))
    change = snider.all_drives(car, [COURSES["lane change"]], (10.0, 15.0))
    return {key[1:]: trace for key, trace in {**eight, **change}.items()}


def test_courses_are_what_they_say():
    change = COURSES["lane change"]
    assert change.at(60.0 + 12.5)[1] == pytest.approx(3.5, abs=0.001)
    assert change.y[-1] == pytest.approx(0.0, abs=0.01)
    within = [x for x, y in zip(change.x, change.y) if 0.005 * 3.5 < y < 0.995 * 3.5 and x < 65.0]
    assert within[-1] - within[0] == pytest.approx(24.5, abs=1.0)
    eight = COURSES["figure-eight"]
    for start, end in eight.measured:
        assert abs(eight.at(0.5 * (start + end))[3]) == pytest.approx(1.0 / 64.0)
    for course in COURSES.values():
        jumps = [abs(b - a) for a, b in zip(course.curvature, course.curvature[1:])]
        assert max(jumps) < 1e-3, "curvature jumps"


def test_place_finds_the_way_back_to_the_course():
    eight = COURSES["figure-eight"]
    for s in (50.0, 200.0, 420.0):
        x, y, heading, curvature = eight.at(s)
        for side in (-1.0, 0.0, 0.7):
            place = eight.place(x - side * math.sin(heading), y + side * math.cos(heading), s - 1.5)
            assert place[:2] == pytest.approx((s, side), abs=0.01)
            assert place[3] == pytest.approx(curvature, abs=1e-4)


def test_figures_of_the_car():
    car, axles = snider.snider_car()
    assert axles.understeer_gradient == 0.0
    assert snider.understeering(car).understeer_gradient == pytest.approx(snider.UNDERSTEER)
    assert car.understeer_gradient == pytest.approx(0.0)


@pytest.mark.parametrize("method", PAPER)
def test_errors_lie_near_the_papers(peaks, method):
    for course, speeds in (("figure-eight", (10.0, 20.0)), ("lane change", (10.0, 15.0))):
        for speed in speeds:
            paper = PAPER_M[course][method][SPEEDS_MPS.index(speed)]
            if paper:
                assert 0.5 < peaks[course, method, speed].peak_m / paper < 2.0, (course, speed)


@pytest.mark.parametrize("method", PAPER)
def test_errors_grow_with_speed_as_in_the_paper(peaks, method):
    paper = PAPER_M["figure-eight"][method]
    grown = peaks["figure-eight", method, 20.0].peak_m / peaks["figure-eight", method, 10.0].peak_m
    assert grown == pytest.approx(paper[3] / paper[1], rel=0.35)


def test_order_of_the_methods_is_the_papers(peaks):
    at_twenty = [
        peaks["figure-eight", method, 20.0].peak_m
        for method in ("pure pursuit", "Stanley", "kinematic", "LQR", "LQR+FF")
    ]
    assert at_twenty == sorted(at_twenty, reverse=True)
    at_ten = [
        peaks["lane change", method, 10.0].peak_m
        for method in ("kinematic", "LQR", "pure pursuit", "Stanley")
    ]
    assert at_ten[0] > at_ten[2] > at_ten[3]
    assert peaks["lane change", "Stanley", 10.0].peak_m < peaks["lane change", "LQR", 10.0].peak_m


def test_the_default_does_better_than_the_papers_geometric_methods(peaks):
    for course, speed in (
        ("figure-eight", 10.0),
        ("figure-eight", 20.0),
        ("lane change", 10.0),
        ("lane change", 15.0),
    ):
        best = min(
            peaks[course, method, speed].centre_peak_m
            for method in ("pure pursuit", "Stanley", "kinematic", "LQR")
        )
        assert peaks[course, OURS, speed].centre_peak_m < best


def test_the_same_figures_in_every_run(peaks):
    car = {"car": snider.understeering(snider.snider_car()[0])}
    again = snider.all_drives(car, [COURSES["lane change"]], (15.0,))
    for method in (*PAPER, OURS):
        assert (
            again["car", "lane change", method, 15.0].peak_m
            == peaks["lane change", method, 15.0].peak_m
        )


def test_a_car_that_is_lost_says_so():
    assert snider_report.metres(math.inf) == "lost"
    car, axles = snider.snider_car()
    straight = snider.Method("asleep", 0.0, 0.05, lambda: lambda course, state, near: 0.0)
    trace = snider.drive(straight, COURSES["figure-eight"], 10.0, car)
    assert not trace.finished
    assert trace.peak_m == math.inf


def test_reflowing_keeps_every_word_and_every_table():
    text = (
        "# Head\n\nA line\nand "
        + "more " * 60
        + "\n\n- one\n  thing\n- **two**: x\n\n| a | b |\n|---|---|\n"
    )
    flowed = snider_report.reflowed(text)
    assert flowed.split() == text.split()
    assert "| a | b |\n|---|---|" in flowed
    assert "- one thing\n- **two**: x" in flowed
    assert max(map(len, flowed.splitlines())) <= 138
