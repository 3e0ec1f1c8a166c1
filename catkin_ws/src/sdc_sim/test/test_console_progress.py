import io

import pytest
from referee_rules import RULES, with_route

from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.report.console_progress import ConsoleProgress, closing_line, progress_line


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Full(io.StringIO):
    def write(self, text):
        raise OSError(28, "No space left on device")


def evaluator_at(tick, wall_clock=False):
    evaluator = with_route()
    for number in range(1, tick + 1):
        wall_s = 0.05 * number if wall_clock else None
        evaluator.add("odometry", number * 50_000_000, 0.5 * number, 0.25, 0.0, 10.0, wall_s)
    return evaluator


def print_drive(stream, seconds, factor=2.0):
    """Print a drive of this wall time [s] that runs at `factor` times real time."""
    progress = ConsoleProgress(stream)
    evaluator = evaluator_at(1)
    tick = 1
    for step in range(int(20 * seconds)):
        while tick < 20 * factor * step / 20.0:
            tick += 1
            evaluator.add("odometry", tick * 50_000_000, 0.5 * tick, 0.25, 0.0, 10.0)
        progress.update(evaluator, 100.0 + step / 20.0)
    return progress


def test_status_updates_in_place_in_a_terminal():
    stream = Terminal()
    print_drive(stream, 4.0).print_line("referee: done")
    text = stream.getvalue()
    assert text.count("\n") == 1
    assert text.endswith("\r\x1b[Kreferee: done\n")
    assert 10 <= text.count("cross-track error") <= 17
    assert "2.0x real time" in text


def test_status_is_printed_as_plain_lines_in_a_log():
    stream = io.StringIO()
    print_drive(stream, 4.5).print_line("referee: done")
    assert "\x1b" not in stream.getvalue()
    assert "\r" not in stream.getvalue()
    lines = stream.getvalue().splitlines()
    assert len(lines) == 2
    assert "cross-track error +0.25 m" in lines[0]


@pytest.mark.parametrize("closed", [False, True])
def test_stream_that_accepts_no_data_raises_nothing(closed):
    stream = Full()
    if closed:
        stream = io.StringIO()
        stream.close()
        stream.isatty = lambda: False
    print_drive(stream, 6.0).print_line("done")


def test_missing_topics_are_printed():
    stream = io.StringIO()
    progress = ConsoleProgress(stream)
    evaluator = Evaluator(RULES)
    for second in range(8):
        progress.update(evaluator, float(second))
    assert stream.getvalue().splitlines() == [
        "referee: waiting for /planner/mission_waypoints and /carla/ego_vehicle/odometry"
    ]
    evaluator.set_route([(0.0, 0.0), (10.0, 0.0)])
    progress.update(evaluator, 100.0)
    assert stream.getvalue().splitlines()[-1] == "referee: waiting for /carla/ego_vehicle/odometry"


def test_progress_line_fits_into_80_columns():
    drive = evaluator_at(80).drive
    assert progress_line(drive) == (
        "referee: 40.0 % 10.0 m/s  cross-track error +0.25 m  0:08 left"
    )
    drive.time_left_s = lambda: 599.7
    assert len(progress_line(drive) + " 68.0x real time") < 80
    assert progress_line(drive).endswith("10:00 left")


def test_status_line_is_cut_to_a_narrow_terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    stream = Terminal()
    print_drive(stream, 1.0)
    assert max(len(part) for part in stream.getvalue().replace("\x1b[K", "").split("\r")) <= 39


def test_closing_line_has_the_real_time_factor_if_there_is_a_wall_clock():
    with_clock, without = evaluator_at(50, wall_clock=True), evaluator_at(50)
    assert closing_line(with_clock.result().metrics).startswith(
        "referee: aborted: 25.0 % of 100 m in 2.5 s (1.0 times real time), cross"
    )
    assert "real time" not in closing_line(without.result().metrics)
