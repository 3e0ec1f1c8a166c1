"""Tests of the contents of the head-up display."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_sim.manual_control import hud
from sdc_sim.physics.vehicle import VehicleCommand


@pytest.mark.parametrize(
    "yaw_deg, expected",
    [
        (0.0, (90, "E")),
        (90.0, (0, "N")),
        (180.0, (270, "W")),
        (-90.0, (180, "S")),
        (45.0, (45, "NE")),
        (-45.0, (135, "SE")),
        (135.0, (315, "NW")),
        (-135.0, (225, "SW")),
        (67.6, (22, "N")),
        (67.4, (23, "NE")),
        (90.4, (0, "N")),
        (450.0, (0, "N")),
    ],
)
def test_compass_is_clockwise_from_north(yaw_deg, expected):
    assert hud.compass(math.radians(yaw_deg)) == expected


@given(st.floats(-100.0, 100.0))
def test_compass_is_in_range_for_any_yaw(yaw_rad):
    degrees, point = hud.compass(yaw_rad)
    assert 0 <= degrees < 360
    assert point


@pytest.mark.parametrize(
    "time_s, expected",
    [
        (0.0, "0:00:00.0"),
        (0.05, "0:00:00.0"),
        (59.95, "0:00:59.9"),
        (61.3, "0:01:01.3"),
        (36000.0, "10:00:00.0"),
    ],
)
def test_clock_shows_tenths_of_seconds(time_s, expected):
    assert hud.clock(time_s) == expected


def test_lines_show_all_readings():
    readings = hud.Readings(
        server_fps=19.6,
        client_fps=30.0,
        map_name="Town03",
        time_s=61.3,
        x_m=1.25,
        y_m=-40.56,
        yaw_rad=0.0,
        speed_mps=10.0,
        manual=True,
    )
    assert dict(hud.lines(readings)) == {
        "Server": "20 FPS",
        "Client": "30 FPS",
        "Map": "Town03",
        "Time": "0:01:01.3",
        "Speed": "36 km/h",
        "Heading": "90\u00b0 E",
        "Location": "1.2, -40.6",
        "Driver": "manual",
    }


def test_unknown_readings_are_dashes():
    lines = dict(hud.lines(hud.Readings()))
    assert [lines[name] for name in ("Map", "Time", "Speed", "Heading", "Location")] == [
        hud.UNKNOWN
    ] * 5
    assert lines["Driver"] == "autopilot"


def test_bars_and_flags_show_the_command():
    command = VehicleCommand(0.4, -0.3, 0.2, hand_brake=True)
    assert hud.bars(command) == (("Throttle", 0.4, 0.0), ("Steer", -0.3, -1.0), ("Brake", 0.2, 0.0))
    assert hud.flags(command) == (("Reverse", False), ("Hand brake", True))


@pytest.mark.parametrize(
    "markings, expected",
    [
        ([1], "Crossed line: broken"),
        ([2, 1, 2], "Crossed line: broken and solid"),
        ([0], "Crossed line: other"),
        ([99], "Crossed line: other"),
        ([], "Crossed line"),
    ],
)
def test_crossed_line_text_names_the_markings(markings, expected):
    assert hud.crossed_line_text(markings) == expected


def test_collision_text_names_the_actor():
    assert hud.collision_text(7) == "Collision with actor 7"
    assert hud.collision_text(7, "pedestrian") == "Collision with pedestrian"


def test_notices_fade_out():
    notices = hud.Notices(duration_s=4.0)
    notices.add("bump", now_s=10.0)
    assert notices.visible(10.0) == notices.visible(12.0) == [("bump", 1.0)]
    assert notices.visible(13.0) == [("bump", 0.5)]
    assert notices.visible(14.0) == []


def test_repeated_notice_starts_again_and_oldest_is_dropped():
    notices = hud.Notices(duration_s=4.0, max_count=2)
    for now_s, text in enumerate(("one", "two", "one")):
        notices.add(text, now_s)
    assert [text for text, _ in notices.visible(2.0)] == ["two", "one"]
    notices.add("three", 2.0)
    assert [text for text, _ in notices.visible(2.0)] == ["one", "three"]


def test_notice_duration_must_be_positive():
    with pytest.raises(ValueError, match="duration"):
        hud.Notices(0.0)


def test_frame_rate_is_averaged_over_its_window():
    rate = hud.FrameRate(window_s=2.0)
    assert rate.per_second(0.0) == 0.0
    for tick in range(100):
        rate.count(0.05 * tick)
    assert rate.per_second(4.95) == pytest.approx(20.0)
    assert rate.per_second(20.0) == 0.0


def test_frame_rate_of_simultaneous_frames_is_zero():
    rate = hud.FrameRate()
    rate.count(1.0)
    rate.count(1.0)
    assert rate.per_second(1.0) == 0.0
