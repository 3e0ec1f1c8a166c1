"""The trace of a drive is written while it lasts, and equals the one written at its end."""

import csv
import random

import numpy as np
import pytest
from referee_rules import RULES

from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.evaluation.event_log import EventLog
from sdc_sim.report.trace_file import TraceFile
from sdc_sim.report.writer import write_report

TICK_NS = 50_000_000
POINTS = np.column_stack([np.arange(401.0), np.zeros(401)])


def drive_on(evaluator, first, last):
    """Drive at 2 m/s; some commands are late, some have no stamp or that of another clock."""
    late = random.Random(5)
    for tick in range(first, last):
        y_m = late.uniform(-1.0, 1.0)
        evaluator.add_odometry(tick * TICK_NS, 0.1 * tick, y_m, 0.01 * y_m, 2.0, wall_s=0.01 * tick)
        stamp = late.choice([tick, tick, tick, tick - 1, tick - 7, 0, 10**9 + tick])
        evaluator.add_command(stamp * TICK_NS, late.uniform(0.0, 1.0), 0.0, -0.1)


def stored(folder, drive_id="drive"):
    folder.mkdir(exist_ok=True)
    trace = TraceFile(str(folder / "report.csv"))
    evaluator = Evaluator(RULES, EventLog(str(folder / "events"), drive_id), trace)
    evaluator.set_route(POINTS)
    return evaluator, trace


def in_memory():
    evaluator = Evaluator(RULES)
    evaluator.set_route(POINTS)
    return evaluator


def assert_same_report(folder, evaluator, trace, expected):
    result = evaluator.result()
    write_report(str(folder / "report.json"), result, trace)
    (folder / "expected").mkdir()
    write_report(str(folder / "expected" / "report.json"), expected.result())
    assert (folder / "report.csv").read_text() == (folder / "expected" / "report.csv").read_text()
    metrics = (folder / "report.json").read_text()
    assert metrics == (folder / "expected" / "report.json").read_text()
    assert not (folder / "report.csv.part").exists()


def test_stored_trace_equals_the_one_kept_in_memory(tmp_path):
    (evaluator, trace), expected = stored(tmp_path), in_memory()
    for each in (evaluator, expected):
        drive_on(each, 1, 3001)
    assert len(evaluator.drive.progress.samples) < 1500, "a long drive does not fill the memory"
    assert_same_report(tmp_path, evaluator, trace, expected)


def test_late_collision_removes_the_samples_after_it(tmp_path):
    (evaluator, trace), expected = stored(tmp_path), in_memory()
    for each in (evaluator, expected):
        drive_on(each, 1, 2001)
        each.add_collision(1990 * TICK_NS, 0)
    assert evaluator.drive.progress.progress_m == pytest.approx(199.0)
    assert_same_report(tmp_path, evaluator, trace, expected)


def test_restarted_world_and_resumed_referee_begin_the_trace_again(tmp_path):
    drive_on(stored(tmp_path)[0], 1, 2001)
    (evaluator, trace), expected = stored(tmp_path), in_memory()
    expected.drive.apply(["resumed"])
    drive_on(expected, 1, 2001)
    for each in (evaluator, expected):
        drive_on(each, 1, 1801)
    assert evaluator.drive.world_restarts == 1
    assert_same_report(tmp_path, evaluator, trace, expected)


def test_failed_trace_is_replaced_by_the_event_log(tmp_path):
    (evaluator, trace), expected = stored(tmp_path), in_memory()
    for each in (evaluator, expected):
        drive_on(each, 1, 2001)
    trace.failure = OSError(28, "No space left on device")
    assert_same_report(tmp_path, evaluator, trace, expected)


def test_reason_of_a_tick_is_the_last_one_before_it(tmp_path):
    """Reasons arrive in any order; without a new one for a second, the reason is unknown."""
    (evaluator, trace), expected = stored(tmp_path), in_memory()
    for each in (evaluator, expected):
        for tick in range(1, 2001):
            each.add_odometry(tick * TICK_NS, 0.1 * tick, 0.0, 0.0, 2.0, wall_s=0.01 * tick)
            if tick == 40:
                each.add_reason(30 * TICK_NS, "bend")
                each.add_reason(20 * TICK_NS, "cruise")
            if tick == 1000:
                each.add_reason(1000 * TICK_NS, "a reason of another stack, " + 100 * "x")
    assert_same_report(tmp_path, evaluator, trace, expected)
    with open(tmp_path / "report.csv", encoding="utf-8", newline="") as file:
        reasons = [row["reason"] for row in csv.DictReader(file)]
    other = ("a reason of another stack, " + 100 * "x")[:40]
    assert reasons[:19] == 19 * [""]
    assert reasons[19:29] == 10 * ["cruise"]
    assert reasons[29:50] == 21 * ["bend"]
    assert reasons[50:999] == 949 * [""]
    assert reasons[999:1020] == 21 * [other]


def test_reasons_of_later_times_do_not_fill_the_memory(tmp_path):
    evaluator, _ = stored(tmp_path)
    for tick in range(1, 3001):
        evaluator.add_odometry(tick * TICK_NS, 0.1 * tick, 0.0, 0.0, 2.0, wall_s=0.01 * tick)
        for number in range(4):
            evaluator.add_reason(10**15 + 4 * tick + number, "later")
    assert len(evaluator.drive._reasons._stamps) <= 5000 + 4 * 200
