"""The scripts of the nodes without ROS: bad messages and parameters, silence, red lights."""

import math
import os

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
from sdc_msgs.msg import SpeedReason
from sdc_package.msg import BaseWaypoint, LocalPath, Path, Waypoint
from sensor_msgs.msg import Image

from sdc_common.planning.stop_line import GREEN, RED
from sdc_common.ros import node as ros_node
from sdc_common.ros import speed_reason_publisher
from sdc_common.ros.odometry import odometry_message
from sdc_testing import load_script

HERE = os.path.dirname(os.path.abspath(__file__))
MISSION, PATH = "/planner/mission_waypoints", "/planner/local_waypoints"
ODOMETRY = "/carla/ego_vehicle/odometry"
PICTURES = "/carla/ego_vehicle/camera/rgb/front/image_color"


class OfflineNode:
    """A node without ROS.

    Attributes:
        receive: its callbacks by topic
        published: the messages that it published
        latched: the topics of its latched publishers
        timers: the functions that it calls periodically
        call: its services by name
        config: its parameters
        instance: the object of its class
        reasons: stamp [ns] and name of what limited the speed, as it published them
    """

    def __init__(self, config):
        self.instance = None
        self.receive = {}
        self.published = []
        self.latched = set()
        self.timers = []
        self.call = {}
        self.config = config
        self.reasons = []

    def serve(self, name, service_class, handler):
        """Take the place of rospy.Service."""
        self.call[name] = lambda: handler(None)

    def subscribe(self, topic, message_class, callback, **options):
        """Take the place of rospy.Subscriber."""
        self.receive[topic] = callback

    def advertise(self, topic, message_class, **options):
        """Take the place of a publisher."""
        self.latched |= {topic} if options.get("latch") else set()
        return self

    def get_num_connections(self):
        """Take the place of the publisher's method."""
        return 1

    def publish(self, message, *_):
        """Take the place of the publisher's method."""
        if isinstance(message, SpeedReason):
            self.reasons.append((message.header.stamp.to_nsec(), message.reason))
        else:
            self.published.append(message)


@pytest.fixture
def offline_node(monkeypatch):
    """Return a function that builds the node of a script, with the parameters of its config."""

    def refuse(message):
        raise ValueError(message)

    def build(name, class_name, **changes):
        script = load_script(os.path.join(HERE, "..", "scripts", name + ".py"))
        path, config = os.path.join(HERE, "..", "config", name + ".yaml"), {}
        if os.path.exists(path):
            with open(path, encoding="utf-8") as file:
                config = yaml.safe_load(file)
        config.update(changes)
        node = OfflineNode(config)

        def get_param(key, *default):
            return config.get(key[1:], *default) if default else config[key[1:]]

        monkeypatch.setattr(rospy, "get_param", get_param)
        monkeypatch.setattr(rospy, "init_node", lambda name: None)
        monkeypatch.setattr(rospy, "logwarn_throttle", lambda seconds, text: None)
        monkeypatch.setattr(rospy, "loginfo", lambda text, *values: None)
        monkeypatch.setattr(rospy, "spin", lambda: None)
        monkeypatch.setattr(rospy, "Publisher", node.advertise)
        monkeypatch.setattr(rospy, "Subscriber", node.subscribe)
        monkeypatch.setattr(rospy, "Service", node.serve)
        monkeypatch.setattr(ros_node, "refuse", refuse)
        every = lambda seconds, call: node.timers.append(call)  # noqa: E731
        for attribute, value in (
            ("refuse", refuse),
            ("LoopPublisher", node.advertise),
            ("watch_connections", lambda: None),
            ("every", every),
        ):
            monkeypatch.setattr(script, attribute, value, raising=False)
        monkeypatch.setattr(speed_reason_publisher, "LoopPublisher", node.advertise)
        node.instance = getattr(script, class_name)()
        return node

    return build


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
        return node.published[-1].steer

    first = steer(1)
    gains = node.config["stanley_compensated"]
    gains["k"] = 2.0 * gains["k"]
    assert steer(2) == pytest.approx(first)
    assert node.call["~reload"]()[0]
    second = steer(3)
    assert second == pytest.approx(2.0 * first, rel=0.05)
    gains["k"] = -1.0
    assert node.call["~reload"]() == (
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
    (answer,) = node.published
    assert answer.steer == pytest.approx(0.0, abs=1e-3)
    for tick in range(2, 50):
        s = 0.25 * (tick - 1) - 8.0
        turned = max(s, 0.0) / 10.0
        x, y = 10.0 + 10.0 * math.sin(turned) + min(s, 0.0), 10.0 * (1.0 - math.cos(turned))
        node.receive[ODOMETRY](odometry(tick, x, side * y, side * turned))
    stops = node.published[1:]
    assert len(stops) > 30
    stamps = [stamp_ns for stamp_ns, reason in node.reasons if reason == "path_timeout"]
    assert len(stamps) == len(node.reasons) > 5
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
        assert (node.published[-1].waypoints[-1].v == 0.0) == stops
        wanted = "traffic_light" if stops else "accelerating"
        assert node.reasons[-1] == (50_000_000 * tick, wanted)


def test_planner_repeats_its_reason_after_a_silence_and_when_time_starts_again(offline_node):
    """A reason of the controller, which brakes in a silence, ends with the next plan."""
    node = offline_node("local_planner", "LocalPlannerNode")
    node.receive[MISSION](mission([(float(x), 0.0) for x in range(101)]))
    for tick in (1, 2, 3, 8, 9, 4):
        node.receive[ODOMETRY](odometry(tick, 40.0, 0.0, 0.0, speed=10.0))
    assert node.reasons == [(50_000_000 * tick, "cruise") for tick in (1, 8, 4)]


def test_controller_brakes_when_odometry_times_out_and_resumes(offline_node, monkeypatch):
    node = offline_node("simple_controller", "SimpleController")
    node.instance.run()
    (check,) = node.timers
    node.receive[ODOMETRY](odometry(1, 0.0, 0.0, 0.0))
    node.receive[PATH](straight_path())
    for time_s in (0.2, 0.5, 0.6):
        monkeypatch.setattr(rospy.Time, "now", lambda time_s=time_s: rospy.Time.from_sec(time_s))
        check()
    assert node.reasons == [(50_000_000, "odometry_timeout")]
    stops = [(one.throttle, one.brake, one.header.stamp.to_nsec()) for one in node.published[1:]]
    assert stops == [(0.0, 0.5, 0)] * 2
    for tick in range(13, 40):
        node.receive[ODOMETRY](odometry(tick, 0.0, 0.0, 0.0, speed=0.0))
        node.receive[PATH](straight_path())
    assert node.published[-1].throttle > 0.3


def test_controller_refuses_bad_messages_and_keeps_the_last_path(offline_node):
    node = offline_node("simple_controller", "SimpleController")
    for points in (
        [],
        [Waypoint(0.0, 0.0, 1.0)],
        [Waypoint(math.nan, 0.0, 1.0), Waypoint(1.0, 0.0, 1.0)],
        [Waypoint(0.0, 0.0, 1.0)] * 3,
        [Waypoint(0.0, 0.0, -1.0), Waypoint(1.0, 0.0, -1.0)],
    ):
        node.receive[PATH](LocalPath(points))
    node.receive[ODOMETRY](odometry(1, math.nan, 0.0, 0.0))
    node.receive[ODOMETRY](odometry(2, 2.0, 1.0, 0.0))
    assert node.published == []
    node.receive[PATH](straight_path())
    node.receive[PATH](LocalPath([]))
    node.receive[ODOMETRY](odometry(20, 2.0, 1.0, 0.0))
    assert len(node.published) == 2 and min(one.steer for one in node.published) > 0.05
    assert "/carla/ego_vehicle/vehicle_control_cmd" in node.latched


def test_planner_refuses_bad_messages_and_keeps_the_last_mission(offline_node):
    node = offline_node("local_planner", "LocalPlannerNode")
    node.receive[MISSION](mission([(float(x), 0.0) for x in range(61)]))
    node.receive[MISSION](mission([(0.0, 0.0)]))
    node.receive[MISSION](mission([(math.nan, 0.0), (1.0, 0.0)]))
    bad = (math.nan, 0.0, 0.0), (0.0, math.inf, 0.0), (5.0, 0.0, math.nan), (5.0, 200.0, 0.0)
    for tick, pose in enumerate((*bad, (30.0, 0.0, 0.0)), start=1):
        node.receive[ODOMETRY](odometry(tick, *pose))
    (path,) = node.published
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
    answer, *_ = node.published
    assert (answer.header.frame_id, answer.encoding) == ("camera", "mono8")
    mask = CvBridge().imgmsg_to_cv2(answer)
    assert mask.shape == (480, 640)
    assert mask[400, 290:320].any() and not mask[400, :280].any()


def test_mission_planner_publishes_its_file_and_refuses_a_bad_one(offline_node, tmp_path):
    path = tmp_path / "route.csv"
    path.write_text("0,0\n1.5,-2\n")
    node = offline_node("mission_planner", "MissionPlanner", waypoints_path=str(path))
    node.instance.run()
    assert node.published == [mission([(0.0, 0.0), (1.5, 2.0)])]
    assert node.latched == {MISSION}
    path.write_text("0,0\n1,x\n")
    with pytest.raises(ValueError, match=f"^{path}, row 2: y is 'x'"):
        offline_node("mission_planner", "MissionPlanner", waypoints_path=str(path))
    with pytest.raises(ValueError, match="waypoints_path is missing; start the node with its"):
        offline_node("mission_planner", "MissionPlanner")


def test_basic_control_answers_each_odometry_with_the_constant_command(offline_node):
    node = offline_node("simple_controller", "SimpleController", basic_control=True)
    node.receive[ODOMETRY](odometry(7, 0.0, 0.0, 0.0))
    (answer,) = node.published
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
