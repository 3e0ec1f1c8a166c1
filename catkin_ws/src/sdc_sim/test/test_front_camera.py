"""Front camera: what its pictures show, and how the simulator hands observations over."""

import io
import socket
import threading
from multiprocessing import Pipe
from multiprocessing.connection import Client

import numpy as np
import pytest
import rospy
from cv_bridge import CvBridge
from geometry_msgs.msg import Vector3

from sdc_common.processes import wait_until
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.camera.boxes import obstacle_box, traffic_light_box
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.renderer import Renderer
from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import GREEN, OFF, RED, YELLOW, TrafficLightState
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.road.road import Road
from sdc_sim.ros import front_camera, picture_feed
from sdc_sim.ros.front_camera import FrontCamera
from sdc_sim.ros.picture_feed import PictureFeed, PictureSettings, connect, packed, unpacked
from sdc_sim.simulation.snapshot import Snapshot


def settings(route="route.csv", daylight=1.0, every_frame=True):
    return PictureSettings(str(route), "", "hero", "0.9.3", daylight, {}, every_frame)


@pytest.fixture
def feed(tmp_path):
    """Return a function that makes a feed, and the name of its socket."""

    def make(every_frame):
        return PictureFeed(path, settings(every_frame=every_frame))

    make.path = path = str(tmp_path)
    return make


def test_lockstep_waits_for_the_camera_and_sends_every_observation(feed):
    sim = feed(every_frame=True)
    car = ObstacleState(101, "car", 60.0, 1.0, 0.2, 4.7, 2.0, 1.45, 3.0)
    light = TrafficLightState(1001, 45.0, -3.0, 0.1, RED)
    sent = [seen_at(tick, *[car] * (tick % 3), lights=(light,)) for tick in range(20)]
    thread = threading.Thread(target=lambda: [sim.show(one) for one in sent])
    thread.start()
    camera, received_settings = connect(feed.path)
    assert received_settings == settings()
    received = []
    for _ in sent:
        camera.send_bytes(b"")
        received.append(unpacked(camera.recv_bytes()))
    thread.join(10.0)
    assert received == sent


def request(sim, camera):
    """Request an observation; wait until the simulator knows."""
    camera.send_bytes(b"")
    wait_until(lambda: sim.is_ready, 10.0, "the request")


def test_real_time_and_repeated_pictures_drop_what_a_busy_camera_cannot_take(feed):
    sim = feed(every_frame=False)
    sim.show(seen_at(1))
    camera, _ = connect(feed.path)
    sim.show(seen_at(2))
    request(sim, camera)
    sim.show(seen_at(3))
    sim.show(seen_at(4))  # while the one before is painted
    assert unpacked(camera.recv_bytes()) == seen_at(3)
    request(sim, camera)
    sim.show(seen_at(5), again=True)
    sim.show(seen_at(5), again=True)
    assert unpacked(camera.recv_bytes()) == seen_at(5)
    assert not camera.poll(0.1)


def test_feed_waits_for_a_request_with_the_default_timeout_that_rospy_sets(feed):
    before = socket.getdefaulttimeout()
    socket.setdefaulttimeout(60.0)
    try:
        sim = feed(every_frame=False)
        camera, _ = connect(feed.path)
        assert not camera.poll(0.2)  # it would be readable at its end
        request(sim, camera)
        sim.show(seen_at(1))
        assert unpacked(camera.recv_bytes()) == seen_at(1)
    finally:
        socket.setdefaulttimeout(before)


def test_neither_end_of_the_feed_accepts_a_process_of_another_user(feed, monkeypatch):
    """The name of the socket is a parameter of the master, which any user can set."""
    feed(every_frame=True)
    shut_down = iter([False, True])
    monkeypatch.setattr(picture_feed.os, "geteuid", lambda: 12345)
    monkeypatch.setattr(picture_feed.rospy, "is_shutdown", lambda: next(shut_down))
    with pytest.raises(rospy.ROSInterruptException):
        connect(feed.path)
    with Client("\0" + feed.path, "AF_UNIX") as camera, pytest.raises(EOFError):
        camera.recv_bytes()


class Executed:
    """Calls a function where it is unpickled."""

    calls = []

    def __reduce__(self):
        return Executed.calls.append, (1,)


def test_camera_runs_no_code_of_a_message(photograph):
    photograph(Executed(), send=lambda link, message: link.send(message))
    assert Executed.calls == []
    whole = packed(seen_at(1, ObstacleState(101, "car", 60.0, 1.0, 0.2, 4.7, 2.0, 1.45, 0.0)))
    for broken in (b"", whole[:-1], whole + b"x", whole[:48] + b"\xff" * (len(whole) - 48)):
        with pytest.raises(ValueError):
            unpacked(broken)


class Published:
    """A publisher that keeps each message as a subscriber receives it."""

    messages = {}

    def __init__(self, topic, message_class):
        self.sent = Published.messages.setdefault(message_class.__name__, [])
        self.message_class = message_class

    def get_num_connections(self):
        return 0

    def publish(self, message):
        buffer = io.BytesIO()
        message.serialize(buffer)
        self.sent.append(self.message_class().deserialize(buffer.getvalue()))


@pytest.fixture
def photograph(monkeypatch, tmp_path):
    """Return a function from observations to the published camera_info and Image messages."""
    monkeypatch.setattr(front_camera, "LoopPublisher", Published)
    monkeypatch.setattr(Published, "messages", {})

    class Transforms:
        def sendTransform(self, transform):  # noqa: N802 (name of tf2)
            run.transform = transform

    monkeypatch.setattr(front_camera.tf2_ros, "StaticTransformBroadcaster", Transforms)
    route = tmp_path / "route.csv"
    route.write_text("".join(f"{x},0\n" for x in range(0, 200, 2)))

    def run(*observations, daylight=1.0, send=lambda link, one: link.send_bytes(packed(one))):
        sim, camera = Pipe()

        def serve():
            for observation in observations:
                sim.recv_bytes()
                send(sim, observation)
            sim.close()

        threading.Thread(target=serve).start()
        FrontCamera(camera, settings(route, daylight)).loop()
        return Published.messages["CameraInfo"], Published.messages["Image"]

    run.road = Road(load_waypoints(str(route)))
    return run


def seen_at(tick, *obstacles, lights=()):
    state = VehicleState(x_m=20.0 + 0.7 * tick, y_m=0.1 * tick, yaw_rad=0.01 * tick)
    return Snapshot(tick * 1_000_000_000 + 50_000_000, state, state, obstacles, lights)


@pytest.mark.slow(3)
def test_each_picture_and_its_camera_info_show_the_observation_of_their_stamp(photograph):
    car = ObstacleState(101, "car", 60.0, 1.0, 0.2, 4.7, 2.0, 1.45, 0.0)
    light = TrafficLightState(1001, 45.0, -3.0, 0.0, RED)
    observations = [seen_at(tick, car, lights=(light,)) for tick in range(1, 15)]
    infos, images = photograph(*observations, daylight=0.8)
    stamps = [observation.stamp_ns for observation in observations]
    for messages in (infos, images):
        assert [one.header.stamp.to_nsec() for one in messages] == stamps
        assert {one.header.frame_id for one in messages} == {"hero/camera/rgb/front"}
    mounted = photograph.transform
    assert (mounted.header.frame_id, mounted.child_frame_id) == ("hero", "hero/camera/rgb/front")
    assert mounted.transform.translation == Vector3(0.7, 0.0, 1.7)
    assert {one.step for one in images} == {4 * 640}
    renderer, boxes = Renderer(photograph.road), [obstacle_box(car), traffic_light_box(light)]
    for image, (_, state, *_) in zip(images, observations):
        expected = renderer.render(state.x_m, state.y_m, state.yaw_rad, boxes, 0.8)
        np.testing.assert_array_equal(CvBridge().imgmsg_to_cv2(image, "bgra8"), expected)


@pytest.mark.slow(3)
@pytest.mark.parametrize(("state", "lamp"), [(RED, 0), (YELLOW, 1), (GREEN, 2)])
def test_red_lamp_is_the_upper_one_and_green_the_lower_one(photograph, state, lamp):
    """The lamps are 0.32 m apart, from 0.2 m below the top of the light."""
    lights = [TrafficLightState(1001, 34.0, -3.0, 0.0, one) for one in (OFF, state)]
    _, (off, image) = photograph(*(seen_at(0, lights=(light,)) for light in lights))
    off, lit = (CvBridge().imgmsg_to_cv2(one, "rgb8").astype(int) for one in (off, image))
    rows, columns = np.nonzero(np.any(lit != off, axis=2))
    height_m = traffic_light_box(lights[0]).height_m - 0.2 - 0.32 * lamp
    (pixel,), _ = CameraModel().project([[33.855, -3.0, height_m]], 20.0, 0.0, 0.0)
    brightness = lit[rows, columns].sum(axis=1)
    bright = brightness == brightness.max()
    assert (columns[bright].mean(), rows[bright].mean()) == pytest.approx(tuple(pixel), abs=1.5)
    red, green, blue = lit[rows[bright][0], columns[bright][0]]
    assert (red > 200, green > 180, blue > 120) == (state != GREEN, state != RED, False)
