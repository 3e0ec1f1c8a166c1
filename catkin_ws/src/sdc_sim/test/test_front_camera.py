"""Front camera: which observations it hands over, and how it draws obstacles and traffic lights."""

import contextlib
import io
from pathlib import Path

import numpy as np
import pytest
from cv_bridge import CvBridge

from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.camera import camera_node, front_camera
from sdc_sim.camera.camera_input import CameraInput
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.camera_node import obstacle_box, remappings_of, traffic_light_box
from sdc_sim.camera.front_camera import FrontCamera
from sdc_sim.camera.renderer import Renderer
from sdc_sim.camera.shared_pictures import SharedPictures
from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import GREEN, OFF, RED, YELLOW, TrafficLightState
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.road.road import Road
from sdc_sim.ros.bridge_generations import GENERATIONS
from sdc_sim.simulation.observation import Observation


class RecordingProcess:
    """A worker process that records what it is sent."""

    def __init__(self, make_handler, arguments, depth, warn, idle):
        self.arguments, self.depth, self.sent, self.closed = arguments, depth, [], False
        self.idle = idle

    def offer(self, item):
        self.sent.append(("offer", item))

    def put(self, item, timeout_s):
        self.sent.append(("put", item))

    def close(self):
        self.closed = True


@pytest.fixture
def shutdown(monkeypatch):
    """Return the functions that run at shutdown."""
    functions = []
    monkeypatch.setattr(front_camera, "WorkerProcess", RecordingProcess)
    monkeypatch.setattr(front_camera.rospy, "on_shutdown", functions.append)
    yield functions
    for function in functions:
        with contextlib.suppress(FileNotFoundError):
            function()


@pytest.mark.parametrize(("every_frame", "way"), [(True, "put"), (False, "offer")])
def test_camera_waits_for_room_in_lockstep_only(shutdown, every_frame, way):
    camera = FrontCamera("route.csv", "hero", GENERATIONS["0.9.3"], 0.5, every_frame)
    camera.show("first")
    camera.daylight, camera.spectator = 0.25, (1.0, 2.0, 3.0, 0.0, 0.1)
    camera.show("second")
    assert camera._process.idle is not every_frame
    assert camera._process.sent == [
        (way, ("first", 0.5, None)),
        (way, ("second", 0.25, (1.0, 2.0, 3.0, 0.0, 0.1))),
    ]
    route, pictures, *others = camera._process.arguments
    assert (route, others) == ("route.csv", ["hero", GENERATIONS["0.9.3"]])
    assert (Path("/dev/shm") / pictures).exists()


def test_repeated_picture_does_not_wait_for_room(shutdown):
    camera = FrontCamera("route.csv", "hero", GENERATIONS["0.9.3"], 0.5, True)
    camera.show("first")
    camera.show("first", again=True)
    assert [way for way, _ in camera._process.sent] == ["put", "offer"]


def test_camera_closes_its_process_and_memory_at_shutdown(shutdown):
    camera = FrontCamera("route.csv", "hero", GENERATIONS["0.9.3"], 1.0, True)
    pictures = Path("/dev/shm") / camera._process.arguments[1]
    assert pictures.exists() and not camera._process.closed
    for function in shutdown:
        function()
    assert camera._process.closed and not pictures.exists()


def test_remappings_of_the_sim_apply_to_the_camera_but_not_its_name():
    argv = ["sim.py", "/image:=/other", "__name:=sim", "__log:=/tmp/sim.log"]
    assert remappings_of(argv) == ["sim.py", "/image:=/other"]


def test_obstacle_is_drawn_with_its_pose_size_and_colour():
    box = obstacle_box(ObstacleState(101, "obstacle", 1.0, 2.0, 0.3, 4.0, 5.0, 6.0, 0.0))
    assert (box.x_m, box.y_m, box.yaw_rad) == (1.0, 2.0, 0.3)
    assert (box.length_m, box.width_m, box.height_m) == (4.0, 5.0, 6.0)
    assert (box.colour_bgr, box.kind) == ((26, 140, 230), "obstacle")


@pytest.mark.parametrize(
    ("state", "brightest"), [(RED, {2}), (YELLOW, {1, 2}), (GREEN, {1}), (OFF, set())]
)
def test_traffic_light_faces_its_cars_and_shows_its_state(state, brightest):
    box = traffic_light_box(TrafficLightState(1001, 3.0, 4.0, 0.5, state))
    assert (box.x_m, box.y_m, box.kind) == (3.0, 4.0, "light")
    assert box.yaw_rad == pytest.approx(0.5 + 3.141592653589793)
    assert {k for k, value in enumerate(box.colour_bgr) if value >= 200} == brightest


class DelayedWorker:
    """A worker in this process, always as many items behind as it may be."""

    made = None

    def __init__(self, make_handler, arguments, depth, warn):
        self.handle, self.depth, self.waiting = make_handler(*arguments), depth, []
        DelayedWorker.made = self

    def put(self, item, timeout_s):
        self.waiting.append(item)
        if len(self.waiting) > self.depth:
            self.handle(self.waiting.pop(0))
        return True

    def finish(self):
        while self.waiting:
            self.handle(self.waiting.pop(0))


class Published:
    """A publisher that keeps each message as a subscriber receives it."""

    messages = {}

    def __init__(self, topic, message_class):
        self.sent = Published.messages.setdefault(message_class.__name__, [])
        self.message_class = message_class

    def publish(self, message):
        buffer = io.BytesIO()
        message.serialize(buffer)
        self.sent.append(self.message_class().deserialize(buffer.getvalue()))


@pytest.fixture
def photograph(monkeypatch, tmp_path):
    """Return a function from observations to the published camera_info and Image messages."""
    monkeypatch.setattr(camera_node, "WorkerProcess", DelayedWorker)
    monkeypatch.setattr(camera_node, "LoopPublisher", Published)
    monkeypatch.setattr(camera_node.rospy, "init_node", lambda *args, **kwds: None)
    monkeypatch.setattr(Published, "messages", {})

    class Transforms:
        def sendTransform(self, transform):  # noqa: N802 (name of tf2)
            pass

    monkeypatch.setattr(camera_node.tf2_ros, "StaticTransformBroadcaster", Transforms)
    route = tmp_path / "route.csv"
    route.write_text("".join(f"{x},0\n" for x in range(0, 200, 2)))
    shared = SharedPictures(CameraModel())

    def run(*observations, daylight=1.0):
        painter = camera_node.BackgroundPainter(
            str(route), shared.name, "hero", GENERATIONS["0.9.3"]
        )
        for observation in observations:
            painter.paint(CameraInput(observation, daylight, None))
        DelayedWorker.made.finish()
        return Published.messages["CameraInfo"], Published.messages["Image"]

    run.road = Road(load_waypoints(str(route)))
    yield run
    shared.remove()


def seen_at(tick, *obstacles, lights=()):
    state = VehicleState(x_m=20.0 + 0.7 * tick, y_m=0.1 * tick, yaw_rad=0.01 * tick)
    return Observation((tick, 50_000_000), state, state, obstacles, lights)


@pytest.mark.slow(3)
def test_each_picture_and_its_camera_info_show_the_observation_of_their_stamp(photograph):
    car = ObstacleState(101, "car", 60.0, 1.0, 0.2, 4.7, 2.0, 1.45, 0.0)
    light = TrafficLightState(1001, 45.0, -3.0, 0.0, RED)
    observations = [seen_at(tick, car, lights=(light,)) for tick in range(1, 15)]
    infos, images = photograph(*observations, daylight=0.8)
    stamps = [observation.stamp for observation in observations]
    for messages in (infos, images):
        assert [(one.header.stamp.secs, one.header.stamp.nsecs) for one in messages] == stamps
        assert {one.header.frame_id for one in messages} == {"hero/camera/rgb/front"}
    renderer, boxes = Renderer(photograph.road), [obstacle_box(car), traffic_light_box(light)]
    for image, (_, state, *_) in zip(images, observations):
        expected = renderer.render(state.x_m, state.y_m, state.yaw_rad, boxes, 0.8)
        np.testing.assert_array_equal(CvBridge().imgmsg_to_cv2(image, "bgra8"), expected)


def test_picture_has_blue_sky_green_grass_and_objects_on_their_own_side(photograph):
    cone = ObstacleState(101, "obstacle", 38.0, 3.0, 0.0, 1.5, 1.5, 1.5, 0.0)
    walker = ObstacleState(102, "pedestrian", 34.0, -2.0, 0.0, 0.5, 0.6, 1.8, 0.0)
    _, (empty, image) = photograph(seen_at(0), seen_at(0, cone, walker))
    rgb, without = (CvBridge().imgmsg_to_cv2(one, "rgb8").astype(int) for one in (image, empty))
    red, green, blue = rgb[5:60].mean(axis=(0, 1))
    assert blue > red + 20.0, "the sky"
    changed = np.any(rgb != without, axis=2)
    orange = changed & (rgb[..., 0] > 140) & (rgb[..., 2] < 60)
    (cone_u, _), (walker_u, _) = CameraModel().project(
        [[38.0, 3.0, 0.7], [34.0, -2.0, 0.9]], 20.0, 0.0, 0.0
    )[0]
    assert cone_u < 310.0 and walker_u > 330.0
    assert np.nonzero(orange)[1].mean() == pytest.approx(cone_u, abs=3.0)
    clothes = changed & (rgb[..., 2] > rgb[..., 0] + 40)
    assert np.nonzero(clothes)[1].mean() == pytest.approx(walker_u, abs=12.0)


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
