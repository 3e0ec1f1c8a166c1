"""Tests of the manual control: keys, head-up display, views and map."""

import math

import numpy as np
import pytest
import rospy
from carla_msgs.msg import CarlaCollisionEvent, CarlaLaneInvasionEvent, CarlaWorldInfo
from sdc_msgs.msg import Obstacle, ObstacleArray

from sdc_common.driving import Command
from sdc_common.ros.odometry import odometry_message
from sdc_sim.manual_control import hud
from sdc_sim.manual_control.drive_state import DriveState
from sdc_sim.manual_control.keyboard import KeyboardControl, KeyboardControlRates
from sdc_sim.manual_control.map_view import MapView

RATES = KeyboardControlRates(
    throttle_per_s=2.0, brake_per_s=4.0, steer_per_s=0.5, steer_return_per_s=2.0, steer_limit=0.7
)
GRASS = (70, 105, 80)


def held_for(seconds, *keys, control=None):
    control = control or KeyboardControl(RATES)
    for _ in range(round(seconds / 0.05)):
        control.step(keys, 0.05)
    return control.command


@pytest.mark.parametrize(
    "keys, expected",
    [
        *((key, Command(throttle=0.4)) for key in ("w", "up")),
        *((key, Command(brake=0.8)) for key in ("s", "down")),
        *((key, Command(steer=-0.1)) for key in ("a", "left")),
        *((key, Command(steer=0.1)) for key in ("d", "right")),
        *((keys, Command()) for keys in ("", "a right")),
        ("w d space", Command(throttle=0.4, steer=0.1, hand_brake=True)),
        ("x q escape", Command()),
    ],
)
def test_held_keys_change_the_command_at_their_rates(keys, expected):
    command = held_for(0.2, *keys.split())
    assert (command.throttle, command.steer, command.brake) == pytest.approx(
        (expected.throttle, expected.steer, expected.brake)
    )
    assert (command.hand_brake, command.reverse) == (expected.hand_brake, expected.reverse)


def test_steering_grows_to_its_limit_and_returns_across_zero():
    control = KeyboardControl(RATES)
    assert held_for(3.0, "d", control=control).steer == 0.7
    assert held_for(0.1, control=control).steer == pytest.approx(0.5)
    assert control.step(["a"], 0.45).steer == pytest.approx(-0.1)  # 0.25 s to zero, then 0.2 s
    assert held_for(0.1, control=control).steer == 0.0


def test_reverse_stays_until_toggled_and_reset_clears_the_command():
    control = KeyboardControl(RATES)
    control.toggle_reverse()
    assert control.step(["w"], 1.0) == Command(throttle=1.0, reverse=True)
    control.toggle_reverse()
    assert control.step(["w"], 1.0) == Command(throttle=1.0)
    control.toggle_reverse()
    control.reset()
    assert control.command == control.step([], 0.0) == Command()


@pytest.mark.parametrize(
    "name, value",
    [("throttle_per_s", 0.0), ("brake_per_s", math.nan), ("steer_per_s", -1.0)]
    + [("steer_return_per_s", math.inf), ("steer_limit", 1.1)],
)
def test_invalid_rate_is_refused_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        KeyboardControlRates(**{**vars(RATES), name: value})


@pytest.mark.parametrize(
    "yaw_deg, expected",
    [(0.0, "90\u00b0 E"), (90.0, "0\u00b0 N"), (180.0, "270\u00b0 W"), (-135.0, "225\u00b0 SW")]
    + [(67.6, "22\u00b0 N"), (67.4, "23\u00b0 NE"), (450.0, "0\u00b0 N")],
)
def test_compass_is_clockwise_from_north(yaw_deg, expected):
    assert hud.compass(math.radians(yaw_deg)) == expected


def test_repeated_notice_starts_again_fades_and_the_oldest_is_dropped():
    clock = Clock()
    state = DriveState(4.0, clock)
    for text in ("one", "two", "one"):
        state.notify(text)
        clock.now_s += 1.0
    clock.now_s += 1.0
    assert state.notices() == [("two", 0.5), ("one", 1.0)]
    clock.now_s += 1.0
    assert state.notices() == [("one", 0.5)]
    for text in "abcd":
        state.notify(text)
    assert [text for text, _ in state.notices()] == ["a", "b", "c", "d"]


class Clock:
    now_s = 100.0

    def __call__(self):
        return self.now_s


def odometry(x=3.0):
    return odometry_message(rospy.Time(7), (x, 0.0, 0.5), (6.0, 0.0, 0.0))


def test_panel_shows_the_newest_values_and_a_dash_for_unknown_ones():
    clock = Clock()
    state = DriveState(3.0, clock)
    expected = dict.fromkeys(("Map", "Time", "Speed", "Heading", "Location"), "-")
    expected.update(Server="0 FPS", Client="30 FPS", Driver="autopilot")
    assert dict(hud.lines(state.readings(is_manual=False, client_fps=30.0))) == expected
    for _ in range(5):
        state.on_odometry(odometry())
        clock.now_s += 0.05
    with pytest.raises(ValueError):
        state.on_odometry(odometry(x=math.nan))
    state.on_world_info(CarlaWorldInfo(map_name="Town03"))
    clock.now_s -= 0.05
    expected = {"Server": "20 FPS", "Client": "30 FPS", "Map": "Town03", "Time": "0:00:07.0"}
    expected.update(Speed="22 km/h", Heading="61\u00b0 NE", Location="3.0, 0.0", Driver="manual")
    assert dict(hud.lines(state.readings(is_manual=True, client_fps=30.0))) == expected
    clock.now_s += 60.0
    assert state.readings(is_manual=True, client_fps=30.0)["server_fps"] < 0.1


def test_events_become_notices():
    state = DriveState(3.0, Clock())
    state.on_obstacles(ObstacleArray(obstacles=[Obstacle(id=9, kind="pedestrian")]))
    state.on_collision(CarlaCollisionEvent(other_actor_id=9))
    state.on_collision(CarlaCollisionEvent(other_actor_id=8))
    state.on_lane_invasion(CarlaLaneInvasionEvent(crossed_lane_markings=[2, 1, 99]))
    hits = ["Collision with pedestrian", "Collision with actor 8"]
    lines = "Crossed line: broken and other and solid"
    assert [text for text, _ in state.notices()] == [*hits, lines]


def colour_at(view, picture, point, pose):
    column, row = np.round(view.to_pixels(point, pose)).astype(int)
    return tuple(int(value) for value in picture[row, column])


@pytest.mark.parametrize("pose", [(20.0, 0.0, 0.0), (20.0, 1.0, 0.5), (50.0, -2.0, math.pi)])
def test_road_path_and_obstacles_are_drawn_at_their_positions(pose):
    view = MapView(0.1, 10.0)
    view.set_route(np.column_stack([np.arange(0.0, 101.0), np.zeros(101)]))
    x, y, yaw = pose
    ahead = x + math.copysign(12.0, math.cos(yaw))
    forward_m = math.cos(yaw) * (ahead - x) - math.sin(yaw) * y
    left_m = -math.sin(yaw) * (ahead - x) - math.cos(yaw) * y
    np.testing.assert_allclose(
        view.to_pixels((ahead, 0.0), pose), (320.0 - left_m / 0.1, 336.0 - forward_m / 0.1)
    )
    plain = view.picture(pose)
    assert colour_at(view, plain, (ahead, 0.0), pose) == (78, 76, 74)
    assert min(colour_at(view, plain, (ahead, -1.75), pose)) > 120
    assert colour_at(view, plain, (ahead, -4.0), pose) == GRASS
    path = [(at, 0.0, 10.0) for at in (x, math.nan, ahead + 1.0, ahead - 1.0)]
    full = view.picture(pose, path, [(ahead, -4.0, 0.3, 2.0, 1.0), (math.nan,) * 5])
    blue, green, red = colour_at(view, full, (ahead, 0.0), pose)
    assert green > 150 > max(blue, red)
    assert colour_at(view, full, (ahead, -4.0), pose) == (30, 130, 240)
