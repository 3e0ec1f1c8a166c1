"""The car stops at the line for red, and for yellow if it can brake comfortably."""

from types import SimpleNamespace as Message

import numpy as np
import pytest
from planned_roads import SETTINGS

from sdc_common.geometry.route import Route
from sdc_common.planning.stop_line import GREEN, RED, YELLOW, StopLine
from sdc_package.traffic_lights import TrafficLightMargins, TrafficLightMonitor

OFF, UNKNOWN = 3, 4
MARGINS, BRAKING_MPS2 = SETTINGS.traffic_lights, SETTINGS.limits.braking_mps2
STRAIGHT = Route(np.column_stack([np.arange(201.0), np.zeros(201)]))
LINE = 100.0
STOP = LINE - MARGINS.gap_m - MARGINS.car_front_m


def lights(state, x=LINE, y=0.0):
    monitor = TrafficLightMonitor(MARGINS)
    monitor.lines = {7: StopLine(x, y, 1.75)}
    monitor.set_states([Message(id=7, state=state)], stamped=True)
    return monitor


def stop(monitor, from_s, speed, horizon=60.0):
    return monitor.stop_s(STRAIGHT, from_s, speed, BRAKING_MPS2, horizon)


@pytest.mark.parametrize(
    ("state", "stops"),
    [(RED, True), (YELLOW, True), (GREEN, False), (OFF, False), (UNKNOWN, False)],
)
def test_car_stops_a_gap_before_the_line_for_red_and_yellow(state, stops):
    assert stop(lights(state), 60.0, 10.0) == (pytest.approx(STOP) if stops else None)


# At 10 m/s a comfortable stop takes 21.7 m and 5 m of reaction; a hard one takes 8.3 m and 5 m
# and may use the gap before the line.
@pytest.mark.parametrize(
    ("state", "room_m", "stops"),
    [
        (YELLOW, 26.8, True),
        (YELLOW, 26.6, False),
        (RED, 26.6, True),
        (RED, 13.4 - 1.0, True),
        (RED, 13.3 - 1.0, False),
    ],
)
def test_car_that_cannot_stop_any_more_drives_through(state, room_m, stops):
    assert (stop(lights(state), STOP - room_m, 10.0) is not None) == stops


def test_car_that_has_begun_to_stop_continues_until_green():
    monitor = lights(YELLOW)
    assert stop(monitor, STOP - 27.0, 10.0) is not None
    assert stop(monitor, STOP - 10.0, 9.0) is not None, "the car has begun to stop"
    monitor.set_states([Message(id=7, state=RED)], stamped=True)
    assert stop(monitor, STOP - 0.5, 0.3) is not None
    monitor.set_states([Message(id=7, state=GREEN)], stamped=True)
    assert stop(monitor, STOP, 0.0) is None
    monitor.set_states([Message(id=7, state=YELLOW)], stamped=True)
    assert stop(monitor, STOP + 0.5, 3.0) is None, "a new yellow is a new decision"


def test_line_behind_the_front_next_to_the_road_or_beyond_the_horizon_is_ignored():
    assert stop(lights(RED), LINE - 2.0, 1.0) is None
    assert stop(lights(RED, y=3.5), 60.0, 10.0) is None, "the next lane"
    assert stop(lights(RED), 30.0, 10.0) is None
    assert stop(lights(RED), LINE - 2.35, 0.2) is None, "the front is at the line"
    assert stop(lights(RED), LINE - 2.0, 0.2) is None
    assert stop(lights(RED), LINE - 2.5, 0.2) is not None, "a creeping car stops anywhere"


def test_monitor_without_messages_stops_nowhere_and_accepts_states_without_a_stamp():
    monitor = TrafficLightMonitor(MARGINS)
    assert stop(monitor, 60.0, 10.0) is None
    monitor.set_states([Message(id=7, state=RED)], stamped=False)
    assert monitor.states == {7: RED}
    assert stop(monitor, 60.0, 10.0) is None, "its line is not known"
    monitor.lines = {7: StopLine(LINE, 0.0, 1.75)}
    assert stop(monitor, 60.0, 10.0) == pytest.approx(STOP)


def test_states_without_a_stamp_are_ignored_while_stamped_ones_arrive():
    monitor = lights(RED)
    monitor.set_states([Message(id=7, state=GREEN)], stamped=False)
    assert monitor.states == {7: RED}
    monitor.set_states([], stamped=True)
    monitor.set_states([Message(id=7, state=GREEN)], stamped=False)
    assert monitor.states == {7: GREEN}


@pytest.mark.parametrize(
    "changes", [{"gap_m": -1.0}, {"reaction_s": float("nan")}, {"hardest_mps2": float("inf")}]
)
def test_margins_out_of_range_are_refused(changes):
    with pytest.raises(ValueError, match=next(iter(changes))):
        TrafficLightMargins(**{**vars(MARGINS), **changes})
