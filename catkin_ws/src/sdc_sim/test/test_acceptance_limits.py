"""Tests of the acceptance limits."""

import pytest

from sdc_sim.evaluation import route_progress
from sdc_sim.evaluation.metrics import COEFFICIENTS
from sdc_sim.report.html_page import MEANINGS
from sdc_sim.scenario.acceptance_limits import read_report, violations
from sdc_sim.yaml_document import schema

STOP = {"at_m": 50.0, "within_m": 1.0}
AT_MOST, NO_JERK = ", at most", "jerk_max_mps3 is not in the report"
NO_STOP = "the car did not stop 50 m along the route (within 1 m); it stopped at: "
REPORT = {"status": "completed", "cross_track_max_m": 0.62, "missed_ticks": 3}
REPORT.update(jerk_max_mps3=None, infractions={"red_light": 1, "collision_static": 2})


@pytest.mark.parametrize(
    ("limits", "stops_m", "lines"),
    [
        (dict(), (), []),
        (dict(at_most={"cross_track_max_m": 0.62}, at_least={"missed_ticks": 3}), (), []),
        (dict(status="collision"), (), ["status is completed, must be collision"]),
        (dict(at_most={"cross_track_max_m": 0.5}), (), [f"cross_track_max_m is 0.62{AT_MOST} 0.5"]),
        (dict(at_least={"missed_ticks": 4}), (), ["missed_ticks is 3, at least 4"]),
        (
            *(dict(at_most={"infractions": 2, "red_light": 0, "collision_static": 2}), ()),
            [f"infractions is 3{AT_MOST} 2", f"red_light is 1{AT_MOST} 0"],
        ),
        (dict(at_most={"jerk_max_mps3": 9.0}), (), [f"{NO_JERK}{AT_MOST} 9"]),
        (dict(stops=[STOP]), (10.0, 51.0), []),
        (dict(stops=[STOP]), (10.0, 51.2), [NO_STOP + "10.0, 51.2"]),
        (dict(stops=[STOP]), (), [NO_STOP + "nowhere"]),
    ],
)
def test_each_violation_is_one_line_with_metric_and_bound(limits, stops_m, lines):
    found = violations(limits, REPORT, stops_m)
    assert [line.replace(" is allowed", "") for line in found] == lines


def test_names_of_limits_are_names_of_the_report():
    limits = schema("scenario")["properties"]["limits"]["properties"]
    metrics = set(schema("scenario")["definitions"]["metrics"])
    assert metrics <= set(MEANINGS)
    assert set(limits["at_most"]["properties"]) == metrics | {"infractions", *COEFFICIENTS}
    names = "COMPLETED", "COLLISION", "OFF_ROUTE", "BLOCKED", "TIMEOUT", "ABORTED"
    statuses = {getattr(route_progress, name) for name in names}
    assert set(limits["status"]["enum"]) == statuses


def test_stops_of_the_car_are_read_from_the_trace(tmp_path):
    (tmp_path / "report.json").write_text('{"status": "completed"}')
    rows = ((0.0, 0.0), (1.0, 2.0), (4.9, 0.05), (5.0, 0.049), (5.0, 0.0), (6.0, 1.0), (9.0, 0.0))
    (tmp_path / "report.csv").write_text("s_m,speed_mps\n" + "".join(f"{s},{v}\n" for s, v in rows))
    assert read_report(str(tmp_path / "report.json")) == ({"status": "completed"}, [5.0, 9.0])
