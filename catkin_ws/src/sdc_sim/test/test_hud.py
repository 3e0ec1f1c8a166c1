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
def test_compass(yaw_deg, expected):
    assert hud.compass(math.radians(yaw_deg)) == expected


@given(st.floats(-100.0, 100.0))
def test_compass_is_always_on_the_dial(yaw_rad):
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
def test_clock(time_s, expected):
    assert hud.clock(time_s) == expected


def test_lines_of_a_drive():
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


def test_lines_before_anything_is_known():
    lines = dict(hud.lines(hud.Readings()))
    assert [lines[name] for name in ("Map", "Time", "Speed", "Heading", "Location")] == [
        hud.NOTHING
    ] * 5
    assert lines["Driver"] == "autopilot"


def test_bars_and_flags():
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
def test_crossed_lines(markings, expected):
    assert hud.crossed_line_text(markings) == expected


def test_collisions():
    assert hud.collision_text(7) == "Collision with actor 7"
    assert hud.collision_text(7, "pedestrian") == "Collision with pedestrian"


def test_notices_fade_and_end():
    notices = hud.Notices(duration_s=4.0)
    notices.say("bump", now_s=10.0)
    assert notices.visible(10.0) == notices.visible(12.0) == [("bump", 1.0)]
    assert notices.visible(13.0) == [("bump", 0.5)]
    assert notices.visible(14.0) == []


def test_the_same_notice_is_renewed_and_the_oldest_makes_room():
    notices = hud.Notices(duration_s=4.0, most=2)
    for now_s, text in enumerate(("one", "two", "one")):
        notices.say(text, now_s)
    assert [text for text, _ in notices.visible(2.0)] == ["two", "one"]
    notices.say("three", 2.0)
    assert [text for text, _ in notices.visible(2.0)] == ["one", "three"]


def test_notices_need_a_duration():
    with pytest.raises(ValueError, match="duration"):
        hud.Notices(0.0)


def test_frame_rate():
    rate = hud.FrameRate(window_s=2.0)
    assert rate.per_second(0.0) == 0.0
    for tick in range(100):
        rate.count(0.05 * tick)
    assert rate.per_second(4.95) == pytest.approx(20.0)
    assert rate.per_second(20.0) == 0.0


def test_frame_rate_of_frames_at_one_time():
    rate = hud.FrameRate()
    rate.count(1.0)
    rate.count(1.0)
    assert rate.per_second(1.0) == 0.0
