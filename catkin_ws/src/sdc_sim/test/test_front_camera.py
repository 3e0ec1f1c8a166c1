"""Front camera: which observations it hands over, and how it draws obstacles and traffic lights."""

import contextlib
from pathlib import Path

import pytest

from sdc_sim.camera import front_camera
from sdc_sim.camera.camera_node import obstacle_box, remappings_of, traffic_light_box
from sdc_sim.camera.front_camera import FrontCamera
from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import GREEN, OFF, RED, YELLOW, TrafficLightState
from sdc_sim.ros.bridge_generations import GENERATIONS


class RecordingProcess:
    """A worker process that records what it is sent."""

    def __init__(self, make_handler, arguments, depth, warn):
        self.arguments, self.depth, self.sent, self.closed = arguments, depth, [], False

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
    assert camera._process.sent == [
        (way, ("first", 0.5, None)),
        (way, ("second", 0.25, (1.0, 2.0, 3.0, 0.0, 0.1))),
    ]
    route, pictures, *others = camera._process.arguments
    assert (route, others) == ("route.csv", ["hero", GENERATIONS["0.9.3"]])
    assert (Path("/dev/shm") / pictures).exists()


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
