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


def path_of(rows):
    path = ReferencePath()
    path.update(rows)
    return path


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
    turned = [i / radius for i in range(40)]
    arc = [(radius * math.sin(angle), radius * (1.0 - math.cos(angle)), speed) for angle in turned]
    method = CompensatedStanleySteering(soft, **GAINS, preview_s=0.0)
    wheel = method.wheel_angle(path_of(arc), x, y, yaw, speed)
    assert wheel == pytest.approx(2.87 / radius + (0.008 - 0.006) * acceleration, abs=0.002)


@given(st.floats(-2.0, 2.0), st.floats(-0.5, 0.5), st.floats(0.0, 20.0), st.floats(-0.5, 0.5))
def test_textbook_method_is_the_law_at_the_front_axle(y, yaw, speed, rate):
    """It uses neither a prediction nor the tyres: yaw rate and compliances have no effect."""
    soft = Axles(front_m=1.435, rear_m=1.435, front_compliance=0.008, rear_compliance=0.006)
    straight = [(float(i), 0.0, 5.0) for i in range(30)]
    front_y = y + 1.435 * math.sin(yaw)
    wanted = stanley_angle(-yaw, front_y, speed, 2.0, 1.0)
    wheel = StanleySteering(soft, **GAINS).wheel_angle(path_of(straight), 5.0, y, yaw, speed, rate)
    assert wheel == pytest.approx(wanted, abs=1e-9)
