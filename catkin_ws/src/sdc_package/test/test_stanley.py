"""Stanley's law, in its textbook form and with its compensations."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles
from sdc_package.steering.loader import load_steering
from sdc_package.steering.stanley import StanleySteering, stanley_angle
from sdc_package.steering.stanley_compensated import CompensatedStanleySteering

AXLES = Axles(front_m=1.435, rear_m=1.435, front_compliance=0.0, rear_compliance=0.0)
GAINS = {"k": 2.0, "softening_mps": 1.0}


def arc(radius, side=1.0, count=40, speed=5.0):
    """Points 1 m apart on a circle, from the origin along x, to the left for side 1."""
    return [
        (radius * math.sin(i / radius), side * radius * (1.0 - math.cos(i / radius)), speed)
        for i in range(count)
    ]


def path_of(rows):
    path = ReferencePath()
    path.update(rows)
    return path


def compensated(rows, x, y, yaw, speed=5.0, **changes):
    """Return the wheel angle of the compensated method."""
    parameters = {**GAINS, "preview_s": 0.0, **changes}
    method = CompensatedStanleySteering(AXLES, **parameters)
    return method.wheel_angle(path_of(rows), x, y, yaw, speed)


def textbook(rows, x, y, yaw, speed=5.0, axles=AXLES, rate=0.0):
    """Return the wheel angle of the textbook method."""
    return StanleySteering(axles, **GAINS).wheel_angle(path_of(rows), x, y, yaw, speed, rate)


def test_law_has_the_value_of_the_formula():
    assert stanley_angle(0.1, 0.5, 4.0, 2.0, 1.0) == pytest.approx(0.1 - math.atan(2.0 * 0.5 / 5.0))
    assert stanley_angle(0.1, 0.5, 4.0, 2.0) == pytest.approx(0.1 - math.atan(2.0 * 0.5 / 4.0))
    assert stanley_angle(0.0, 0.5, -4.0, 2.0, 1.0) == stanley_angle(0.0, 0.5, 4.0, 2.0, 1.0)


@pytest.mark.parametrize("k", [0.4, 2.5, 6.0])
def test_gain_decides_how_hard_the_car_steers_back(k):
    expected = -math.atan(k * 0.5 / (4.0 + 1.0))
    assert stanley_angle(0.0, 0.5, 4.0, k, 1.0) == pytest.approx(expected)
    path = path_of([(float(i), 0.0, 4.0) for i in range(30)])
    parameters = {"k": k, "softening_mps": 1.0}
    for method in (
        StanleySteering(AXLES, **parameters),
        CompensatedStanleySteering(AXLES, **parameters, preview_s=0.0),
        load_steering("stanley", parameters, AXLES),
        load_steering("stanley_compensated", {**parameters, "preview_s": 0.0}, AXLES),
    ):
        assert method.wheel_angle(path, 5.0, 0.5, 0.0, 4.0) == pytest.approx(expected)


def test_compensated_method_adds_the_wheel_angle_of_the_slip():
    """On a circle, wheel and heading change by the compliances times the lateral acceleration."""
    soft = Axles(front_m=1.435, rear_m=1.435, front_compliance=0.008, rear_compliance=0.006)
    radius, speed = 40.0, 10.0
    acceleration = speed**2 / radius
    along = 15.0 / radius
    yaw = along - math.asin(1.435 / radius) + 0.006 * acceleration
    x, y = radius * math.sin(along), radius * (1.0 - math.cos(along))
    method = CompensatedStanleySteering(soft, **GAINS, preview_s=0.0)
    wheel = method.wheel_angle(path_of(arc(radius)), x, y, yaw, speed)
    assert wheel == pytest.approx(2.87 / radius + (0.008 - 0.006) * acceleration, abs=0.002)


@given(st.floats(-2.0, 2.0), st.floats(-0.5, 0.5), st.floats(0.0, 20.0), st.floats(-0.5, 0.5))
def test_textbook_method_is_the_law_at_the_front_axle(y, yaw, speed, rate):
    """It uses neither a prediction nor the tyres: yaw rate and compliances have no effect."""
    soft = Axles(front_m=1.435, rear_m=1.435, front_compliance=0.008, rear_compliance=0.006)
    straight = [(float(i), 0.0, 5.0) for i in range(30)]
    front_y = y + 1.435 * math.sin(yaw)
    wanted = stanley_angle(-yaw, front_y, speed, 2.0, 1.0)
    assert textbook(straight, 5.0, y, yaw, speed, soft, rate) == pytest.approx(wanted, abs=1e-9)


def test_textbook_method_cuts_a_corner_that_the_compensated_method_drives():
    """With its centre on a circle, the textbook law steers inwards."""
    radius = 8.0
    slip = math.asin(1.435 / radius)
    along = 12.0 / radius
    pose = radius * math.sin(along), radius * (1.0 - math.cos(along)), along - slip
    ideal = math.atan(2.0 * math.tan(slip))
    assert compensated(arc(radius), *pose) == pytest.approx(ideal, abs=0.02)
    assert textbook(arc(radius), *pose) > ideal + 0.05
