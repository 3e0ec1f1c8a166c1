"""The referee node without ROS: the messages of another stack become a report."""

import json
import os
import shutil
import threading
from pathlib import Path

import pytest
import rospy
from carla_msgs.msg import CarlaCollisionEvent
from sdc_msgs.msg import BaseWaypoint, CarlaVehicleControl, Obstacle, ObstacleArray
from sdc_msgs.msg import Path as Mission
from sensor_msgs.msg import Image

from sdc_common.configuration import node_config
from sdc_common.processes import wait_until
from sdc_common.ros.node import ENDED_PARAMETER
from sdc_common.ros.odometry import odometry_message
from sdc_testing.offline_node import offline_node

SCRIPT = Path(__file__).resolve().parents[1] / "scripts" / "referee.py"
EGO = "/carla/ego_vehicle"
PICTURES = EGO + "/camera/rgb/front/image_color"
IMAGE = Image(height=48, width=64, encoding="bgra8", step=256, data=bytes(48 * 256))


@pytest.fixture
def start(monkeypatch, tmp_path):
    """Return a function that starts a referee and sends it a route along the x axis."""

    def begin(**changes):
        config = {**node_config("sdc_sim", "referee"), "pictures": False, "snapshots": 0, "/": {}}
        config.update(report=str(tmp_path / "report" / "report.json"), **changes)
        node = offline_node(monkeypatch, str(SCRIPT), "Referee", config)
        points = [BaseWaypoint(float(x), 0.0) for x in range(101)]
        send(node, "/planner/mission_waypoints", Mission(points))
        return node

    return begin


def send(node, topic, message):
    message._connection_header = {"topic": topic}
    node.receive[topic](message)


def drive(node, first=1, last=220):
    """Send a drive along the route at 10 m/s, 0.3 m to the left.

    As with the 0.9.3 bridge, the twist is in the map frame and commands carry no stamps.
    """
    for tick in range(first, last):
        pose, speed = (min(0.5 * tick, 100.0), 0.3, 0.5), 10.0 if tick < 200 else 0.0
        stamp, twist = rospy.Time.from_sec(0.05 * tick), (0.6 * speed, -0.8 * speed, 0.0)
        send(node, EGO + "/odometry", odometry_message(stamp, pose, twist))
        send(node, EGO + "/vehicle_control_cmd", CarlaVehicleControl(throttle=0.5))


def test_another_stack_is_evaluated_by_the_topics_of_the_contract(start, tmp_path, monkeypatch):
    folder, pauses = tmp_path / "report", []
    monkeypatch.setattr(rospy, "wait_for_service", lambda *_: None)
    report_exists = (folder / "report.json").exists
    pause = lambda *_: lambda: pauses.append(report_exists())  # noqa: E731
    monkeypatch.setattr(rospy, "ServiceProxy", pause)
    node = start()
    (path,) = node.published["/planner/mission_path"]
    assert path.header.frame_id == "map"
    places = [(pose.pose.position.x, pose.pose.position.y) for pose in path.poses]
    assert places == [(float(x), 0.0) for x in range(101)]
    assert node.latched == {"/planner/mission_path", "/referee/rules"}
    assert not node.config[ENDED_PARAMETER]
    drive(node)
    assert node.instance.run() == 0
    assert pauses == [False], "one time, before the report exists"
    assert node.config[ENDED_PARAMETER], "no node warns of the stopped clock"
    report = json.loads((folder / "report.json").read_text())
    assert report["status"] == "completed"
    found = [report[name] for name in ("cross_track_rms_m", "speed_max_mps", "heading_rms_rad")]
    assert found == pytest.approx([0.3, 10.0, 0.5], abs=1e-6)
    assert "planned_speed_mps" in report["assumed_limits"]
    assert sorted(os.listdir(folder)) == ["report.csv", "report.json", "report.parameters.json"]


def test_removed_folder_does_not_end_the_drive(start, tmp_path, capsys, caplog):
    node, folder = start(), tmp_path / "report"
    drive(node, 1, 100)
    shutil.rmtree(folder)
    folder.write_text("")
    drive(node, 100)
    assert node.instance.run() == 1
    assert "completed: 100.0 %" in capsys.readouterr().out
    assert f"{folder}: File exists; the drive is not reported" in caplog.text


@pytest.mark.slow(3)
def test_collision_ends_the_drive_and_the_page_has_a_snapshot(start, tmp_path):
    node, folder, statuses = start(pictures=True, snapshots=2), tmp_path / "report", []
    running = threading.Thread(target=lambda: statuses.append(node.instance.run()))
    running.start()
    pedestrian = ObstacleArray(obstacles=[Obstacle(id=103, kind="pedestrian")])
    send(node, EGO + "/obstacles", pedestrian)
    drive(node, 1, 120)
    wait_until(lambda: PICTURES in node.receive, 30.0, "the subscription to the camera")
    node.receive[PICTURES](IMAGE)
    wait_until(lambda: PICTURES not in node.receive, 30.0, "the end of the subscription")
    send(node, EGO + "/collision", CarlaCollisionEvent(other_actor_id=103))
    running.join(60.0)
    assert statuses == [1]
    report = json.loads((folder / "report.json").read_text())
    assert report["status"] == "collision"
    infractions = {name for name, count in report["infractions"].items() if count}
    assert infractions == {"collision_pedestrian"}
    score = 0.5 * report["route_completion_percent"]
    assert report["driving_score"] == pytest.approx(score)
    endings = "csv", "html", "json", "parameters.json", "png"
    assert sorted(os.listdir(folder)) == [f"report.{one}" for one in endings]
    assert "data:image/jpeg" in (folder / "report.html").read_text()
