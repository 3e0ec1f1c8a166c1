import io
import os

import numpy as np
import pytest
import yaml

from sdc_sim.evaluation.evaluator import EvaluationRules, Evaluator
from sdc_sim.report.console_progress import ConsoleProgress, closing_line, progress_line

with open(
    os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "config", "referee.yaml"),
    encoding="utf-8",
) as config:
    RULES = EvaluationRules.read(yaml.safe_load(config).get)


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Full(io.StringIO):
    def write(self, text):
        raise OSError(28, "No space left on device")


def watch_at(tick):
    watch = Evaluator(RULES)
    watch.mission(np.column_stack([np.arange(101.0), np.zeros(101)]))
    for number in range(1, tick + 1):
        watch.odometry(number * 50_000_000, 0.5 * number, 0.25, 0.0, 10.0)
    return watch


def told(stream, seconds, factor=2.0):
    """What is said in so many seconds of wall time, looked at often, while the drive runs `factor` times real time."""
    progress = ConsoleProgress(stream)
    watch = watch_at(1)
    tick = 1
    for step in range(int(20 * seconds)):
        while tick < 20 * factor * step / 20.0:
            tick += 1
            watch.odometry(tick * 50_000_000, 0.5 * tick, 0.25, 0.0, 10.0)
        progress.update(watch, 100.0 + step / 20.0)
    return progress


def test_one_line_stays_in_its_place_in_a_terminal():
    stream = Terminal()
    told(stream, 4.0).say("referee: done")
    text = stream.getvalue()
    assert text.count("\n") == 1
    assert text.endswith("\r\x1b[Kreferee: done\n")
    assert 10 <= text.count("cross-track error") <= 17
    assert "2.0x real time" in text


def test_plain_lines_in_a_log():
    stream = io.StringIO()
    told(stream, 4.5).say("referee: done")
    assert "\x1b" not in stream.getvalue()
    assert "\r" not in stream.getvalue()
    lines = stream.getvalue().splitlines()
    assert len(lines) == 2
    assert "cross-track error +0.25 m" in lines[0]


@pytest.mark.parametrize("closed", [False, True])
def test_a_stream_that_takes_nothing_ends_no_drive(closed):
    stream = Full()
    if closed:
        stream = io.StringIO()
        stream.close()
        stream.isatty = lambda: False
    told(stream, 6.0).say("done")


def test_waiting_is_told_with_what_is_missing():
    stream = io.StringIO()
    progress = ConsoleProgress(stream)
    watch = Evaluator(RULES)
    for second in range(8):
        progress.update(watch, float(second))
    assert stream.getvalue().splitlines() == [
        "referee: waiting for /planner/mission_waypoints and /carla/ego_vehicle/odometry"
    ]
    watch.mission([(0.0, 0.0), (10.0, 0.0)])
    progress.update(watch, 100.0)
    assert stream.getvalue().splitlines()[-1] == "referee: waiting for /carla/ego_vehicle/odometry"


def test_the_line():
    line = progress_line(42.31, 9.84, -0.027, 71.4, 1.0)
    assert line == "referee: 42.3 %  9.8 m/s  cross-track error -0.03 m  1:11 left 1.0x real time"
    assert len(progress_line(99.9, 10.0, 0.0, 600.0, 68.0)) < 80
    assert progress_line(0.0, 0.0, 0.0, 59.7, None).endswith("1:00 left")


def test_a_narrow_terminal_is_not_overrun(monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    stream = Terminal()
    told(stream, 1.0)
    assert max(len(part) for part in stream.getvalue().replace("\x1b[K", "").split("\r")) <= 39


def test_closing_line_with_and_without_a_clock():
    watch = watch_at(50)
    watch.began_at_s = 0.0
    assert closing_line(watch.result(2.45).figures).startswith(
        "referee: aborted: 25.0 % of 100 m in 2.5 s (1.0 times real time), cross"
    )
    assert "real time" not in closing_line(watch.result().figures)
