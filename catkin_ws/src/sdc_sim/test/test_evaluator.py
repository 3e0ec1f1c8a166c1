import math
import os
import re

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from sdc_sim.evaluation.evaluator import EvaluationRules, Evaluator
from sdc_sim.evaluation.event_log import EventLog
from sdc_sim.physics.traffic_lights import GREEN, RED

POINTS = np.column_stack([np.arange(101.0), np.zeros(101)])
TICK_NS = 50_000_000
with open(
    os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "config", "referee.yaml"),
    encoding="utf-8",
) as config:
    RULES = EvaluationRules.read(yaml.safe_load(config).get)


def drive_on(watch, first, ticks, speed=10.0, answer=True):
    for tick in range(first, first + ticks):
        watch.wall_clock(100.0 + 0.01 * tick)
        watch.odometry(
            tick * TICK_NS,
            min(0.05 * speed * tick, 100.0),
            0.2,
            0.0,
            speed if 0.05 * speed * tick < 100.0 else 0.0,
        )
        if answer:
            watch.command(tick * TICK_NS, 0.001 * tick, 0.0, -0.1)


def watched(journal=None):
    watch = Evaluator(RULES, journal)
    watch.mission(POINTS)
    return watch


def test_a_whole_drive():
    watch = watched()
    drive_on(watch, 1, 300)
    result = watch.result(ended_at_s=102.0)
    figures = result.figures
    assert figures["status"] == "completed"
    assert figures["duration_s"] == pytest.approx(9.95)
    assert figures["ticks"] == 200
    assert figures["missed_ticks"] == 0
    assert figures["cross_track_rms_m"] == pytest.approx(0.2)
    assert figures["wall_duration_s"] == pytest.approx(102.0 - 100.02), (
        "the first tick may have been repeated"
    )
    assert figures["real_time_factor"] == pytest.approx(9.95 / 1.98)
    np.testing.assert_allclose(result.commands[:, 0], 0.001 * np.arange(1, 201))


def test_what_comes_before_the_route_is_kept():
    early, watch = Evaluator(RULES), watched()
    drive_on(early, 1, 30)
    early.mission(POINTS)
    drive_on(watch, 1, 30)
    assert early.result().figures == watch.result().figures


@pytest.mark.parametrize("kills", [(100,), (1, 2, 60, 150)])
def test_a_killed_watch_is_gone_on_with_to_the_same_figures(tmp_path, kills):
    whole = watched()
    drive_on(whole, 1, 300)
    first, path = 1, str(tmp_path / "journal")
    for kill in (*kills, 300):
        watch = watched(EventLog(path, "drive"))
        drive_on(watch, first, kill - first)
        first = kill
    expected, got = whole.result(102.0), watch.result(102.0)
    assert got.figures == {**expected.figures, "referee_restarts": len(kills)}
    assert got.drive.samples == expected.drive.samples
    np.testing.assert_array_equal(got.commands, expected.commands)


def test_another_route_begins_another_drive(tmp_path):
    path = str(tmp_path / "journal")
    drive_on(watched(EventLog(path, "drive")), 1, 100)
    watch = Evaluator(RULES, EventLog(path, "drive"))
    watch.mission(POINTS + 1.0)
    assert watch.drive.samples == []
    drive_on(watch, 100, 50)
    assert watch.result().figures["referee_restarts"] == 0
    assert watch.result().figures["ticks"] == 50


def test_time_that_nobody_saw_is_told(tmp_path):
    watch = watched()
    drive_on(watch, 1, 50)
    drive_on(watch, 110, 50)
    assert watch.result().figures["unseen_s"] == pytest.approx(3.0)


def test_a_world_that_begins_anew_is_a_new_drive():
    anew, watch = watched(), watched()
    drive_on(watch, 1, 150)
    drive_on(watch, 1, 300)
    drive_on(anew, 5, 296)
    assert watch.result(102.0).figures == {**anew.result(102.0).figures, "world_restarts": 1}


def test_a_watch_with_a_journal_keeps_nothing(tmp_path):
    watch = watched(EventLog(str(tmp_path / "journal"), "drive"))
    drive_on(watch, 1, 150)
    assert len(watch.drive.samples) == 1
    assert len(watch.result().drive.samples) == 150


@pytest.mark.parametrize(
    ("number", "kind"),
    [(101, "vehicle"), (102, "pedestrian"), (103, "static"), (7, "vehicle"), (0, "static")],
)
def test_what_the_car_ran_into(number, kind):
    watch = watched()
    for known, name in ((101, "car"), (102, "pedestrian"), (103, "obstacle")):
        watch.obstacle(known, name)
    drive_on(watch, 1, 50)
    watch.collision(40 * TICK_NS, number)
    figures = watch.result().figures
    assert figures["status"] == "collision"
    assert {name for name, count in figures["infractions"].items() if count} == {
        "collision_" + kind
    }
    assert figures["ticks"] == 40


@given(st.lists(st.sampled_from(["odometry", "collision"]), min_size=1))
def test_a_collision_is_the_same_whenever_it_is_heard(order):
    watch = watched()
    drive_on(watch, 1, 20)
    tick = 21
    told = False
    for what in (*order, "collision"):
        if what == "odometry" and tick < 60:
            drive_on(watch, tick, 1)
            tick += 1
        elif what == "collision" and not told:
            watch.collision(30 * TICK_NS, 5)
            told = True
    drive_on(watch, tick, 30)
    assert watch.result().figures["ticks"] == 30
    assert watch.result().drive.samples[-1].s_m == pytest.approx(15.0)


def test_commands_without_stamps_belong_to_what_was_heard_last():
    watch = watched()
    for tick in range(1, 20):
        drive_on(watch, tick, 1, answer=False)
        watch.command(0, 0.5, 0.0, 0.01 * tick)
    result = watch.result()
    assert result.figures["missed_ticks"] == 18
    np.testing.assert_allclose(result.commands[:, 2], 0.01 * np.arange(1, 20))


def test_a_command_is_in_force_until_the_next():
    watch = watched()
    drive_on(watch, 1, 3, answer=False)
    drive_on(watch, 4, 1)
    drive_on(watch, 5, 3, answer=False)
    np.testing.assert_allclose(watch.result().commands[:, 0], [math.nan] * 3 + [0.004] * 4)


def test_infractions_outlive_a_kill(tmp_path):
    path = str(tmp_path / "journal")
    first = watched(EventLog(path, "drive"))
    drive_on(first, 1, 50)
    first.infraction("red_light")
    second = watched(EventLog(path, "drive"))
    drive_on(second, 50, 250)
    result = second.result()
    assert result.figures["infractions"]["red_light"] == 1
    assert result.figures["driving_score"] == pytest.approx(100.0 / 1.4)
    assert [(event.name, round(event.time_s, 2)) for event in result.drive.events] == [
        ("red_light", 2.5),
        ("completed", 10.0),
    ]
    with pytest.raises(ValueError, match=re.escape("they are:")):
        second.infraction("red_lihgt")


def test_a_mission_that_is_no_route():
    with pytest.raises(ValueError, match="at least 2 points"):
        Evaluator(RULES).mission([(0.0, 0.0)])


def test_time_left():
    watch = watched()
    drive_on(watch, 1, 1)
    assert watch.time_left_s() == pytest.approx(watch.ideal_duration_s, abs=0.5)
    drive_on(watch, 2, 198)
    assert 0.0 <= watch.time_left_s() < 1.0
    assert math.isfinite(watch.time_left_s())


def drive_past_a_light(watch, shown):
    """Along the road at 10 m/s, over a stop line at 50 m that the car's front reaches in tick 96; `shown` gives the state at a tick."""
    watch.stop_lines({7: (50.0, 0.0, 1.75)})
    for tick in range(1, 201):
        drive_on(watch, tick, 1)
        watch.lights(tick * TICK_NS, {7: shown(tick)})
    return watch


@pytest.mark.parametrize(
    ("red", "count"), [(range(300), 1), (range(96), 0), (range(97, 300), 0), (range(96, 97), 1)]
)
@pytest.mark.parametrize("kept", [False, True])
def test_red_light_counts_when_the_front_crosses_the_line(red, count, kept, tmp_path):
    watch = drive_past_a_light(
        watched(EventLog(str(tmp_path / "journal"), "drive") if kept else None),
        lambda tick: RED if tick in red else GREEN,
    )
    figures = watch.result().figures
    assert figures["infractions"]["red_light"] == count
    assert (figures["driving_score"] < 99.0) == bool(count)
