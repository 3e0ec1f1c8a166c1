"""Traffic lights in rendered pictures."""

import math

import pytest

from sdc_common.configuration import node_config
from sdc_perception.light_detection import GREEN, RED, YELLOW, LightFinder, LightSettings
from sdc_perception.light_tracker import LightTracker
from sdc_sim.camera.camera_model import CameraModel

CAMERA_X_M = 0.7
INTRINSIC = CameraModel().intrinsic_matrix()
pytestmark = pytest.mark.slow(3)
OFF = 3
STILL = (0.0, 0.0, 0.0)


@pytest.fixture
def settings():
    return LightSettings.read(node_config("sdc_perception", "traffic_light_detector").__getitem__)


@pytest.fixture
def finder(settings):
    return LightFinder(settings, INTRINSIC)


@pytest.mark.parametrize("brightness", [1.0, 0.25])
@pytest.mark.parametrize("ahead_m", [6.6, 12.0, 25.0, 38.0])
@pytest.mark.parametrize("state", [RED, YELLOW, GREEN])
def test_state_and_place_of_a_light(finder, render, light, state, ahead_m, brightness):
    found = finder.find(render(light(state, ahead_m), brightness=brightness))
    assert [one.state for one in found] == [state]
    assert found[0].x_m - CAMERA_X_M == pytest.approx(ahead_m, rel=0.05)
    assert found[0].y_m == pytest.approx(-2.7, abs=0.15)


@pytest.mark.parametrize("brightness", [1.0, 0.25])
def test_no_light_where_none_faces_the_car(finder, render, light, brightness):
    away, off = light(RED, 15.0, turned_rad=math.pi), light(OFF, 20.0, 3.0)
    assert finder.find(render(away, off, brightness=brightness)) == []


def test_lamp_in_the_place_of_another_is_no_light(finder, render, light):
    """A red picture of a green lamp: the dark lamps would have to be below it."""
    picture = render(light(GREEN, 12.0))
    picture[..., [1, 2]] = picture[..., [2, 1]]
    assert finder.find(picture) == []


def test_colour_changes_with_the_second_picture(settings, render, light):
    tracker = LightTracker(settings, INTRINSIC)
    states = []
    for number, state in enumerate([GREEN, GREEN, GREEN, RED, RED, RED]):
        lights = tracker.detect(render(light(state, 20.0)), STILL, 0.05 * number)
        states.append([one.state for one in lights])
    assert states == [[], [GREEN], [GREEN], [GREEN], [RED], [RED]]


def test_light_stays_at_its_place_while_the_car_moves(settings, render, light):
    tracker = LightTracker(settings, INTRINSIC)
    for number in range(8):
        pose = (3.0 * number, 0.0, 0.01 * number)
        lights = tracker.detect(render(light(RED, 35.0), pose=pose), pose, 0.3 * number)
    assert [one.id for one in lights] == [1]
    assert (lights[0].x_m, lights[0].y_m) == pytest.approx((35.0 + CAMERA_X_M, -2.7), abs=0.4)
