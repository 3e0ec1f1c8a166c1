"""What steering methods share: the paths of the axles, and the prediction of the pose."""

import math

import pytest

from sdc_common.geometry.polyline import Polyline
from sdc_package.steering.axles import Axles, axle_path
from sdc_package.steering.method import predicted_pose

BEND = [(0, 0), (1, 0.1), (1.7, 0.22), (3, 0.54), (3.6, 0.72), (4.5, 1.06), (5, 1.3), (5.8, 1.74)]
SOFT = Axles(front_m=1.2, rear_m=1.6, front_compliance=0.008, rear_compliance=0.006)


def slips(line, count, rear_m):
    """Return the slip angle at each point: many small steps of du/ds = curvature - sin(u)/rear."""
    found = [0.0]
    for i in range(1, count):
        length = line.lengths[i - 1]
        curvature = (line.headings[i] - line.headings[i - 1]) / length
        slip = found[-1] if i > 1 else math.asin(rear_m * curvature)
        for _ in range(2000):
            slip += length / 2000 * (curvature - math.sin(slip) / rear_m)
        found.append(slip)
    return found


@pytest.mark.parametrize("count", [2, 5, 8])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("ahead_m", [SOFT.front_m, -SOFT.rear_m])
def test_axle_follows_the_kinematic_bicycle_and_the_slip_of_its_tyres(ahead_m, side, count):
    """The points of the bend are at uneven distances. The tyres slip between its ends."""
    line = Polyline([(x, side * y) for x, y in BEND])
    wanted = []
    for i, slip in enumerate(slips(line, count, rear_m=1.6)):
        tyre_slip = 0.0
        if 0 < i < count - 1:
            turn = line.headings[i + 1] - line.headings[i - 1]
            tyre_slip = 0.006 * 10.0**2 * turn / (line.s[i + 1] - line.s[i - 1])
        yaw = line.headings[i] - slip + tyre_slip
        x, y = line.points[i]
        wanted.append((x + ahead_m * math.cos(yaw), y + ahead_m * math.sin(yaw)))
    got = axle_path(line, count, 10.0, SOFT, ahead_m).points
    assert len(got) == count
    for point, wanted_point in zip(got, wanted):
        assert point == pytest.approx(wanted_point, abs=1e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"front_m": 0.0}, "front_m must be a positive number, got 0.0"),
        ({"rear_m": -1.0}, "rear_m must be a positive number, got -1.0"),
        ({"front_compliance": -0.1}, "front_compliance must be a number that is not negative"),
        ({"rear_compliance": math.nan}, "rear_compliance must be a number that is not negative"),
    ],
)
def test_invalid_axles_are_refused(change, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        Axles(**{**vars(SOFT), **change})


@pytest.mark.parametrize("yaw", [0.0, 0.5, -2.0])
@pytest.mark.parametrize("rate", [0.0, 1.0, -0.8])
def test_prediction_follows_the_arc_of_the_car(yaw, rate):
    """Many small steps along the heading give the arc."""
    x, y, heading = 1.0, 2.0, yaw
    for _ in range(1000):
        heading += 0.5 * rate * 0.3 / 1000
        x, y = x + 0.003 * math.cos(heading), y + 0.003 * math.sin(heading)
        heading += 0.5 * rate * 0.3 / 1000
    predicted = predicted_pose(1.0, 2.0, yaw, 10.0, rate, 0.3)
    assert predicted == pytest.approx((x, y, yaw + 0.3 * rate), abs=0.02)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_jump_of_the_pose_is_not_a_yaw_rate(side):
    wanted = predicted_pose(1.0, 2.0, 0.5, 10.0, side * 1.5, 0.1)
    assert predicted_pose(1.0, 2.0, 0.5, 10.0, side * 60.0, 0.1) == wanted
    assert wanted[2] == pytest.approx(0.5 + side * 0.15)
