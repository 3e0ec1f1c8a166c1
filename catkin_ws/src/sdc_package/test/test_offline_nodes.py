"""The scripts of the nodes without ROS: bad messages and parameters, silence, red lights."""

import math
import os
import sys

import numpy as np
import pytest
import rospy
import yaml
from carla_msgs.msg import (
    CarlaTrafficLightInfo,
    CarlaTrafficLightInfoList,
    CarlaTrafficLightStatus,
    CarlaTrafficLightStatusList,
)
from cv_bridge import CvBridge
from geometry_msgs.msg import PoseStamped
from sdc_msgs.srv import CloseLaneRequest
from sdc_package.msg import BaseWaypoint, LocalPath, Path, Waypoint
from sensor_msgs.msg import Image

from sdc_common.planning.stop_line import GREEN, RED
from sdc_common.ros.odometry import odometry_message
from sdc_testing import offline_node as offline
from sdc_testing.street_maps import needs_maps, town

HERE = os.path.dirname(os.path.abspath(__file__))
MISSION, PATH = "/planner/mission_waypoints", "/planner/local_waypoints"
ODOMETRY = "/carla/ego_vehicle/odometry"
COMMAND = "/carla/ego_vehicle/vehicle_control_cmd"
PICTURES = "/carla/ego_vehicle/camera/rgb/front/image_color"


@pytest.fixture
def offline_node(monkeypatch):
    """Return a function that builds the node of a script, with the parameters of its config.

    The nodes of the car work where the world is not installed.
    """
    for name in [name for name in sys.modules if name.partition(".")[0] == "sdc_sim"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "sdc_sim", None)

    def build(name, class_name, **changes):
        path, config = os.path.join(HERE, "..", "config", name + ".yaml"), {}
        if os.path.exists(path):
            with open(path, encoding="utf-8") as file:
                config = yaml.safe_load(file)
        script = os.path.join(HERE, "..", "scripts", name + ".py")
        return offline.offline_node(monkeypatch, script, class_name, {**config, **changes})

    return build


def reasons(node):
    """Return stamp [ns] and name of what limited the speed, as a node published them."""
    sent = node.published["/planner/speed_reason"]
    return [(message.header.stamp.to_nsec(), message.reason) for message in sent]


def odometry(tick, x, y, yaw, speed=5.0):
    """Return an odometry whose twist is in the map frame, as that of the CARLA bridge 0.9.3."""
    stamp = rospy.Time(0, 50_000_000 * tick)
    return odometry_message(stamp, (x, y, yaw), (0.6 * speed, -0.8 * speed, 0.0))


def straight_path(speed=5.0):
    return LocalPath([Waypoint(float(x), 0.0, speed) for x in range(30)])


def mission(points):
    return Path([BaseWaypoint(x, y) for x, y in points])


def test_reload_uses_a_new_gain_and_refuses_a_bad_one(offline_node):
    node = offline_node("simple_controller", "SimpleController")

    def steer(tick):
        node.receive[ODOMETRY](odometry(tick, 2.0 + 0.25 * tick, 0.1, 0.0))
        node.receive[PATH](straight_path())
        return node.published[COMMAND][-1].steer

    first = steer(1)
    gains = node.config["stanley_compensated"]
    gains["k"] = 2.0 * gains["k"]
    assert steer(2) == pytest.approx(first)
    assert node.call["~reload"](None)[0]
    second = steer(3)
    assert second == pytest.approx(2.0 * first, rel=0.05)
    gains["k"] = -1.0
    assert node.call["~reload"](None) == (
        False,
        "section 'stanley_compensated': k must be a positive number, got -1.0",
    )
    assert steer(4) == pytest.approx(second)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_stop_for_a_silent_planner_steers_along_the_last_path(offline_node, side):
    """The straight before the bend takes longer than the timeout."""
    node = offline_node("simple_controller", "SimpleController")
    along = np.arange(0.0, 20.0)
    bend = np.column_stack([10.0 * np.sin(along / 10.0), side * 10.0 * (1 - np.cos(along / 10.0))])
    points = [(x, 0.0) for x in range(10)] + [(10.0 + x, y) for x, y in bend]
    node.receive[ODOMETRY](odometry(1, 2.0, 0.0, 0.0))
    node.receive[PATH](LocalPath([Waypoint(x, y, 5.0) for x, y in points]))
    (answer,) = node.published[COMMAND]
    assert answer.steer == pytest.approx(0.0, abs=1e-3)
    for tick in range(2, 50):
        s = 0.25 * (tick - 1) - 8.0
        turned = max(s, 0.0) / 10.0
        x, y = 10.0 + 10.0 * math.sin(turned) + min(s, 0.0), 10.0 * (1.0 - math.cos(turned))
        node.receive[ODOMETRY](odometry(tick, x, side * y, side * turned))
    stops = node.published[COMMAND][1:]
    assert len(stops) > 30
    stamps = [stamp_ns for stamp_ns, reason in reasons(node) if reason == "path_timeout"]
    assert len(stamps) == len(reasons(node)) > 5
    assert np.diff(stamps).tolist() == [250_000_000] * (len(stamps) - 1), "not in every tick"
    assert {(stop.throttle, stop.brake, stop.header.stamp.to_nsec()) for stop in stops} == {
        (0.0, 0.5, 0)
    }
    assert stops[0].steer == pytest.approx(0.0, abs=0.02)
    assert side * stops[-1].steer < -0.1, "a positive steer turns right"


def test_planner_stops_for_the_red_light_of_a_bridge_without_stamps(offline_node):
    node = offline_node("local_planner", "LocalPlannerNode")
    node.receive[MISSION](mission([(float(x), 0.0) for x in range(101)]))
    light = CarlaTrafficLightInfo(id=7)
    light.transform.position.x = 50.0
    light.transform.orientation.z = 1.0
    light.trigger_volume.size.x, light.trigger_volume.size.y = 1.0, 3.5
    node.receive["/carla/traffic_lights/info"](CarlaTrafficLightInfoList(traffic_lights=[light]))
    for tick, (state, stops) in enumerate(((RED, True), (GREEN, False), (RED, True)), start=1):
        status = CarlaTrafficLightStatusList([CarlaTrafficLightStatus(id=7, state=state)])
        node.receive["/carla/traffic_lights/status"](status)
        node.receive[ODOMETRY](odometry(tick, 28.0, 0.0, 0.0))
        assert (node.published[PATH][-1].waypoints[-1].v == 0.0) == stops
        wanted = "traffic_light" if stops else "accelerating"
        assert reasons(node)[-1] == (50_000_000 * tick, wanted)


def test_planner_repeats_its_reason_after_a_silence_and_when_time_starts_again(offline_node):
    """A reason of the controller, which brakes in a silence, ends with the next plan."""
    node = offline_node("local_planner", "LocalPlannerNode")
    node.receive[MISSION](mission([(float(x), 0.0) for x in range(101)]))
    for tick in (1, 2, 3, 8, 9, 4):
        node.receive[ODOMETRY](odometry(tick, 40.0, 0.0, 0.0, speed=10.0))
    assert reasons(node) == [(50_000_000 * tick, "cruise") for tick in (1, 8, 4)]


def test_controller_brakes_when_odometry_times_out_and_resumes(offline_node, monkeypatch):
    node = offline_node("simple_controller", "SimpleController")
    node.instance.run()
    (check,) = node.timers
    node.receive[ODOMETRY](odometry(1, 0.0, 0.0, 0.0))
    node.receive[PATH](straight_path())
    for time_s in (0.2, 0.5, 0.6):
        monkeypatch.setattr(rospy.Time, "now", lambda time_s=time_s: rospy.Time.from_sec(time_s))
        check()
    assert reasons(node) == [(50_000_000, "odometry_timeout")]
    stops = node.published[COMMAND][1:]
    assert [(command.throttle, command.brake) for command in stops] == [(0.0, 0.5)] * 2
    assert not any(command.header.stamp.to_nsec() for command in stops)
    for tick in range(13, 40):
        node.receive[ODOMETRY](odometry(tick, 0.0, 0.0, 0.0, speed=0.0))
        node.receive[PATH](straight_path())
    assert node.published[COMMAND][-1].throttle > 0.3


def test_controller_refuses_bad_messages_and_keeps_the_last_path(offline_node):
    node = offline_node("simple_controller", "SimpleController")
    for points in ([], [Waypoint(math.nan, 0.0, 1.0), Waypoint(1.0, 0.0, 1.0)]):
        node.receive[PATH](LocalPath(points))
    node.receive[ODOMETRY](odometry(1, math.nan, 0.0, 0.0))
    node.receive[ODOMETRY](odometry(2, 2.0, 1.0, 0.0))
    assert node.published[COMMAND] == []
    node.receive[PATH](straight_path())
    node.receive[PATH](LocalPath([]))
    node.receive[ODOMETRY](odometry(20, 2.0, 1.0, 0.0))
    steers = [command.steer for command in node.published[COMMAND]]
    assert len(steers) == 2 and min(steers) > 0.05
    assert COMMAND in node.latched


def test_planner_refuses_bad_messages_and_keeps_the_last_mission(offline_node):
    node = offline_node("local_planner", "LocalPlannerNode")
    node.receive[MISSION](mission([(float(x), 0.0) for x in range(61)]))
    node.receive[MISSION](mission([(0.0, 0.0)]))
    node.receive[MISSION](mission([(math.nan, 0.0), (1.0, 0.0)]))
    bad = (math.nan, 0.0, 0.0), (0.0, math.inf, 0.0), (5.0, 0.0, math.nan), (5.0, 200.0, 0.0)
    for tick, pose in enumerate((*bad, (30.0, 0.0, 0.0)), start=1):
        node.receive[ODOMETRY](odometry(tick, *pose))
    (path,) = node.published[PATH]
    assert path.waypoints[0].x == 30.0
    assert PATH in node.latched


@pytest.mark.parametrize(("encoding", "channels"), [("bgra8", 4), ("bgr8", 3), ("rgb8", 3)])
def test_camera_publishes_the_mask_and_refuses_bad_pictures(offline_node, encoding, channels):
    node = offline_node("camera", "Camera", show_window=False)
    road = np.full((480, 640, channels), 90, np.uint8)
    road[:, 300:310] = 255
    picture = CvBridge().cv2_to_imgmsg(road, encoding)
    picture.header.frame_id = "camera"
    wrong = Image(height=480, width=640, step=2560, encoding="bgra8", data=b"short")
    strange = Image(height=1, width=1, step=4, encoding="nonsense", data=b"1234")
    for image in (Image(), wrong, strange, picture):
        image._connection_header = {"topic": PICTURES}
        node.receive[PICTURES](image)
    (answer,) = node.published["/camera/lane_mask"]
    assert (answer.header.frame_id, answer.encoding) == ("camera", "mono8")
    mask = CvBridge().imgmsg_to_cv2(answer)
    assert mask.shape == (480, 640)
    assert mask[400, 290:320].any() and not mask[400, :280].any()


def test_mission_planner_publishes_its_file_and_refuses_a_bad_one(offline_node, tmp_path):
    path = tmp_path / "route.csv"
    path.write_text("0,0\n1.5,-2\n")
    node = offline_node("mission_planner", "MissionPlanner", waypoints_path=str(path))
    node.instance.run()
    assert node.published[MISSION] == [mission([(0.0, 0.0), (1.5, 2.0)])]
    assert node.latched == {MISSION}
    path.write_text("0,0\n1,x\n")
    with pytest.raises(ValueError, match=f"^{path}, row 2: y is 'x'"):
        offline_node("mission_planner", "MissionPlanner", waypoints_path=str(path))
    with pytest.raises(ValueError, match="waypoints_path is missing; start the node with its"):
        offline_node("mission_planner", "MissionPlanner")


@needs_maps
def test_global_planner_publishes_missions_to_its_goals_and_closes_lanes(offline_node, tmp_path):
    path = town(tmp_path)
    node = offline_node("global_planner", "GlobalPlannerNode", map=path, goals=[[250.0, -2.0]])
    missions, limits = node.published[MISSION], node.published["/planner/mission_speed_limits"]

    def mission_ends():
        """Return the place where the last mission of a car in the west ends."""
        node.receive[ODOMETRY](odometry(1, -140.0, -1.6, 0.0))
        points = [(point.x, point.y) for point in missions[-1].waypoints]
        assert points == [(point.x, point.y) for point in limits[-1].waypoints]
        return points[-1]

    assert mission_ends() == pytest.approx((250.0, -1.6), abs=3.0)
    assert {point.v for point in limits[-1].waypoints} == {14.0}
    goal = PoseStamped()
    goal.pose.position.x, goal.pose.position.y = -2.0, -110.0
    node.receive["/move_base_simple/goal"](goal)
    assert mission_ends() == pytest.approx((-1.6, -110.0), abs=3.0)
    close = node.call["/planner/close_lane"]
    answer = close(CloseLaneRequest("nowhere"))
    assert (answer.success, answer.message) == (False, "the map town has no lane 'nowhere'")
    assert close(CloseLaneRequest("c_1")).success
    assert {MISSION, "/planner/mission_speed_limits"} <= node.latched
    for bad, words in (
        ({"map": "/none.xodr", "goals": []}, "/none.xodr: cannot be read"),
        ({"map": path, "goals": [[1.0]]}, "not enough values to unpack"),
    ):
        with pytest.raises(ValueError, match=words):
            offline_node("global_planner", "GlobalPlannerNode", **bad)


def test_basic_control_answers_each_odometry_with_the_constant_command(offline_node):
    node = offline_node("simple_controller", "SimpleController", basic_control=True)
    node.receive[ODOMETRY](odometry(7, 0.0, 0.0, 0.0))
    (answer,) = node.published[COMMAND]
    assert answer.header.stamp == rospy.Time(0, 350_000_000)
    wanted = node.config["basic_throttle"], node.config["basic_steer"], 0.0
    assert (answer.throttle, answer.steer, answer.brake) == wanted


@pytest.mark.parametrize(
    ("script", "node", "changes", "message"),
    [
        (
            "simple_controller",
            "SimpleController",
            {"steering_method": "stanly"},
            "'stanly': did you mean 'stanley'",
        ),
        ("simple_controller", "SimpleController", {"basic_throttle": 2.0}, "basic_throttle"),
        ("simple_controller", "SimpleController", {"stop_brake": 2.0}, "stop_brake"),
        ("simple_controller", "SimpleController", {"patience_s": 0.0}, "patience_s"),
        ("local_planner", "LocalPlannerNode", {"braking_mps2": -3.0}, "braking_mps2"),
    ],
)
def test_node_refuses_a_bad_parameter_by_its_name(offline_node, script, node, changes, message):
    with pytest.raises(ValueError, match=f"^config/{script}.yaml: .*{message}"):
        offline_node(script, node, **changes)
