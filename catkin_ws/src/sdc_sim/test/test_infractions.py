import numpy as np
import pytest

from sdc_common.geometry.route import Route
from sdc_sim.evaluation.infractions import RedLightDetector
from sdc_sim.physics.traffic_lights import GREEN, RED

ROUTE = Route(np.column_stack([np.arange(101.0), np.zeros(101)]))
FRONT_M = 2.0
LINE_M = 50.0
# The front is on the line when the centre is at 48 m: at stamp 49 at one metre per stamp.
CROSSING = 49


def detector_of_one_line(x=LINE_M, y=0.0):
    detector = RedLightDetector(FRONT_M)
    detector.set_lines({7: (x, y, 1.75)})
    return detector


def drive(detector, states, first=1, last=100, late=0):
    """Return the crossings on red of a car that drives one metre per stamp.

    `states` arrive `late` stamps after their odometry; with late=0 they arrive before it.
    """
    count = 0
    for stamp in range(first, last):
        if late <= 0:
            count += detector.update_lights(stamp, {7: states(stamp)})
        count += detector.update_car(stamp, ROUTE, float(stamp) - 0.5)
        if late > 0 and stamp > late:
            count += detector.update_lights(stamp - late, {7: states(stamp - late)})
    return count


@pytest.mark.parametrize("late", [0, 1, 5])
@pytest.mark.parametrize(
    ("red", "count"),
    [((0, 200), 1), ((0, CROSSING), 0), ((CROSSING, 200), 1), ((CROSSING + 1, 200), 0)],
)
def test_state_at_the_crossing_counts_in_any_order_of_arrival(red, count, late):
    detector = detector_of_one_line()
    states = lambda stamp: RED if red[0] <= stamp < red[1] else GREEN  # noqa: E731
    assert drive(detector, states, late=late) == count


@pytest.mark.parametrize(("z_m", "count"), [(10.0, 0), (4.5, 1), (float("nan"), 1)])
def test_line_below_a_bridge_does_not_count(z_m, count):
    detector = RedLightDetector(FRONT_M)
    detector.set_lines({7: (LINE_M, 0.0, 1.75, 4.0)})
    found = 0
    for stamp in range(2, 60):
        found += detector.update_lights(stamp, {7: RED})
        found += detector.update_car(stamp, ROUTE, float(stamp), z_m)
    assert found == count


def test_line_on_another_lane_or_beyond_the_drive_does_not_count():
    assert drive(detector_of_one_line(y=3.5), lambda stamp: RED) == 0
    assert drive(detector_of_one_line(), lambda stamp: RED, last=40) == 0


def test_car_that_rolls_back_on_the_line_crosses_it_only_one_time():
    detector = detector_of_one_line()
    detector.update_lights(1, {7: RED})
    places = enumerate((47.0, 48.5, 47.5, 48.5, 47.0, 49.0), start=2)
    count = sum(detector.update_car(stamp, ROUTE, s) for stamp, s in places)
    assert count + detector.update_lights(9, {7: RED}) == 1


def test_without_stamps_the_last_state_counts():
    detector = detector_of_one_line()
    assert detector.update_lights(0, {7: RED}) == 0
    crossed = (detector.update_car(stamp, ROUTE, float(stamp)) for stamp in range(40, 60))
    assert sum(crossed) == 1
    detector.reset_car()
    detector.update_lights(0, {7: GREEN})
    crossed = (detector.update_car(stamp, ROUTE, float(stamp - 20)) for stamp in range(60, 80))
    assert sum(crossed) == 0


def test_line_near_a_later_pass_of_the_route_counts_on_the_first_one():
    there, back = range(101), range(100, -1, -1)
    there_and_back = Route([(float(x), 0.0) for x in there] + [(float(x), 1.0) for x in back])
    detector = detector_of_one_line(x=60.0, y=0.8)
    detector.update_lights(0, {7: RED})
    crossed = [detector.update_car(s, there_and_back, float(s)) for s in range(50, 70)]
    assert sum(crossed) == 1
