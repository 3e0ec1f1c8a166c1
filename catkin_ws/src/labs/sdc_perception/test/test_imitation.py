"""Samples of drives with their answers, and the network that is trained on them."""

import math
import re

import numpy as np
import pytest
import rosbag
import rospy
from sensor_msgs.msg import Image

from sdc_common.ros.odometry import odometry_message
from sdc_perception.imitation.bag import ODOMETRY, PICTURES, bag_samples
from sdc_perception.imitation.record import record_route
from sdc_perception.imitation.samples import Samples
from sdc_perception.imitation_samples import (
    REAR_M,
    SHORTEST_LOOK_AHEAD_M,
    Answer,
    DrivenLine,
    arc_path,
    road_view,
)


def samples(count):
    """Return views with a bright line, which is farther to the right the more the answer is."""
    random = np.random.default_rng(0)
    shifts = random.uniform(-1.0, 1.0, count)
    views = random.integers(60, 90, (count, 40, 128, 3), dtype=np.uint8)
    for view, shift in zip(views, shifts):
        column = 64 + round(50 * shift)
        view[:, column - 4 : column + 4] = 250
    answers = np.column_stack([0.1 * shifts, 6.0 + 2.0 * shifts])
    return Samples(views, answers, np.arange(count) % 2 == 1)


def test_samples_are_read_as_written(tmp_path):
    path, written = str(tmp_path / "samples.npz"), samples(4)
    written.save(path)
    read = Samples.load(path)
    for name in ("views", "answers", "off_line"):
        assert (getattr(read, name) == getattr(written, name)).all()
    assert len(read.only(~read.off_line)) == 2
    assert len(Samples.joined([read, written])) == 8


@pytest.mark.parametrize("content", [None, b"", b"hello"])
def test_bad_file_of_samples_is_refused_in_one_line(tmp_path, content):
    path = tmp_path / "samples.npz"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ValueError, match=f"^{path}: [^\n]*$"):
        Samples.load(str(path))


def write_bag(path, pictures=True):
    """Write a drive of 5 s at 8 m/s along x, with a picture in each tick."""
    with rosbag.Bag(str(path), "w") as bag:
        for tick in range(100):
            stamp = rospy.Time.from_sec(10.0 + 0.05 * tick)
            odometry = odometry_message(stamp, (0.4 * tick, 0.0, 0.0), (8.0, 0.0, 0.0))
            bag.write(ODOMETRY, odometry, stamp)
            if pictures:
                picture = Image(height=480, width=640, encoding="bgra8", step=2560)
                picture.header.stamp = stamp
                picture.data = bytes([tick]) * (480 * 2560)
                bag.write(PICTURES, picture, stamp)


@pytest.mark.slow(1)
def test_bag_gives_five_pictures_a_second_with_their_answers(tmp_path):
    write_bag(tmp_path / "drive.bag")
    found = bag_samples(str(tmp_path / "drive.bag"), 2.0, 5.0)
    assert set(found.views[:, 0, 0, 0]) <= set(range(0, 100, 4))
    # The last pictures have no road ahead that was driven.
    assert 20 <= len(found) <= 22
    assert found.answers == pytest.approx(np.tile([0.0, 8.0], (len(found), 1)), abs=1e-6)
    assert not found.off_line.any()


def test_bag_without_pictures_is_refused(tmp_path):
    write_bag(tmp_path / "drive.bag", pictures=False)
    with pytest.raises(ValueError, match="has no message of .*image_color"):
        bag_samples(str(tmp_path / "drive.bag"), 2.0, 5.0)
    with pytest.raises(ValueError, match="cannot be read"):
        bag_samples(str(tmp_path / "missing.bag"), 2.0, 5.0)


@pytest.mark.nightly
@pytest.mark.slow(3)
def test_training_finds_the_line_in_the_views(capsys):
    pytest.importorskip("torch", reason="torch is not installed (docker/prepare imitation)")
    from sdc_perception.imitation.train import train

    network = train(samples(220), updates=40)
    printed = re.findall(r"loss ([\d.]+), curvature error ([\d.]+)", capsys.readouterr().out)
    first, last = ([float(number) for number in row] for row in (printed[0], printed[-1]))
    assert last[0] < 0.2 * first[0]
    # On the samples that were not trained on.
    assert last[1] < 0.025
    left, right = (network.answer(view) for view in samples(220).views[[3, 5]])
    answers = samples(220).answers[[3, 5]]
    assert (left.curvature_1pm < right.curvature_1pm) == (answers[0, 0] < answers[1, 0])


@pytest.mark.nightly
def test_pictures_of_the_expert_are_on_its_line_and_off_it():
    found = record_route(3, length_m=60.0)
    assert len(found) > 20
    assert found.off_line.tolist() == [False, True] * (len(found) // 2)
    on_line = found.only(~found.off_line)
    assert np.abs(on_line.answers[:, 0]).max() < 0.15
    assert on_line.answers[:, 1].min() > 2.0


@pytest.mark.nightly
@pytest.mark.slow(12)
def test_network_that_steers_straight_on_drives_a_straight_road(tmp_path):
    torch = pytest.importorskip("torch", reason="docker/prepare imitation installs it")
    from sdc_perception.imitation.drive import drive
    from sdc_perception.imitation_network import SteeringNetwork, build_network

    layers = build_network()
    with torch.no_grad():
        for values in layers.parameters():
            values.zero_()
        list(layers.parameters())[-1][1] = 1.0
    SteeringNetwork(layers).save(str(tmp_path / "network.npz"))
    route_m = np.column_stack([np.arange(40.0), np.zeros(40)])
    metrics = drive(str(tmp_path / "network.npz"), route_m).metrics
    assert metrics["status"] == "completed"
    assert metrics["cross_track_max_m"] < 0.05


SPEED_MPS = 4.0
TIMES_S = np.arange(0.0, 10.0, 0.05)


def circle(radius_m):
    """Return the line of a car whose rear axle drives a left bend around (0, radius_m)."""
    yaw = SPEED_MPS * TIMES_S / radius_m
    rear = radius_m * np.column_stack([np.sin(yaw), 1.0 - np.cos(yaw)])
    centre = rear + REAR_M * np.column_stack([np.cos(yaw), np.sin(yaw)])
    return DrivenLine(TIMES_S, np.column_stack([centre, yaw]), np.full(len(yaw), SPEED_MPS))


def test_answer_on_the_line_is_what_the_driver_did():
    assert circle(20.0).answer(50) == pytest.approx((1.0 / 20.0, SPEED_MPS), abs=1e-4)
    assert circle(1e6).answer(50) == pytest.approx((0.0, SPEED_MPS), abs=1e-4)


@pytest.mark.parametrize(("left_m", "turned_rad"), [(0.8, 0.0), (-0.8, 0.0), (0.5, 0.2)])
def test_answer_beside_a_straight_line_leads_back_to_it(left_m, turned_rad):
    line = circle(1e6)
    curvature_1pm, _ = line.answer(50, left_m, turned_rad)
    x, y, yaw = line.displaced(50, left_m, turned_rad)
    rear_x, rear_y = x - REAR_M * math.cos(yaw), y - REAR_M * math.sin(yaw)
    assert rear_y == pytest.approx(left_m, abs=0.01)
    # The end of the arc is on the line, at the look-ahead distance.
    centre = np.array(
        [rear_x - math.sin(yaw) / curvature_1pm, rear_y + math.cos(yaw) / curvature_1pm]
    )
    ahead = np.array([line.poses[50, 0] + SHORTEST_LOOK_AHEAD_M, 0.0])
    assert np.hypot(*(ahead - centre)) == pytest.approx(abs(1.0 / curvature_1pm), abs=0.01)


@pytest.mark.parametrize("curvature_1pm", [0.1, -0.05, 1e-9])
def test_rear_axle_of_the_path_drives_the_arc(curvature_1pm):
    pose = 3.0, -2.0, 0.7
    path = arc_path(pose, Answer(curvature_1pm, 6.0))
    assert set(path[:, 2]) == {6.0}
    distances = np.hypot(*(path[:, :2] - pose[:2]).T)
    assert distances.min() == pytest.approx(0.0, abs=1e-9)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    rear = np.array(pose[:2]) - REAR_M * np.array([c, s])
    centre = rear + np.array([-s, c]) / curvature_1pm
    radius_m = math.hypot(1.0 / curvature_1pm, REAR_M)
    assert np.hypot(*(path[:, :2] - centre).T) == pytest.approx(radius_m, abs=1e-6)


def test_view_is_the_road_in_the_picture():
    picture = np.zeros((480, 640, 4), np.uint8)
    picture[:240] = 255
    picture[300:320, 100:200] = 200
    view = road_view(picture)
    assert view.shape == (40, 128, 3)
    assert (view[12:16, 20:40] == 200).all()
    assert view.sum() == 3 * 200 * 4 * 20
    with pytest.raises(ValueError, match="640 x 480 pixels, got 320 x 240"):
        road_view(picture[::2, ::2])
