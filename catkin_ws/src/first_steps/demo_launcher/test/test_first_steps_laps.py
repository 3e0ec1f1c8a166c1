"""Test that the driver completes laps in the world from any start, on every shape of route."""

import math
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

sys.path.insert(0, str(Path(__file__).resolve().parent))
from first_steps_shapes import SHAPES, drive, packaged

pytestmark = pytest.mark.slow(10)

STARTS = st.tuples(st.floats(-400.0, 400.0), st.floats(-225.0, 225.0), st.floats(-math.pi, math.pi))


def few(examples):
    return settings(max_examples=examples, deadline=None)


@pytest.mark.parametrize("shape", sorted(SHAPES))
def test_driver_completes_laps_on_every_shape_from_any_start(shape):
    @given(start=STARTS, delay=st.integers(0, 1))
    @few(10)
    def laps(start, delay):
        assert drive(SHAPES[shape], start, laps=2, delay=delay) is not None

    laps()


@pytest.mark.nightly
@pytest.mark.parametrize("shape", sorted(set(SHAPES) - {"two points"}))
@pytest.mark.parametrize("front_only", [False, True])
def test_driver_completes_laps_with_the_sensor_alone(shape, front_only):
    """The points are close enough together for the range of the sensor."""

    @given(start=STARTS)
    @few(10)
    def laps(start):
        assert (
            drive(
                SHAPES[shape],
                start,
                {"sensor_front_only": front_only},
                {"use_map": False},
                laps=2,
                step_limit=12000,
            )
            is not None
        )

    laps()


@pytest.mark.parametrize("speed", [10.0, 60.0, 240.0, 300.0, 600.0])
def test_driver_completes_laps_at_other_speeds(speed):
    """At 300 u/s the turning circle exceeds the reach: only a run-up prevents endless circles."""
    for start in ((0.0, 0.0, 0.0), (390.0, 215.0, 1.0), (-350.0, 10.0, -2.0)):
        assert drive(SHAPES["ellipse"], start, {"speed": speed}) is not None


def test_default_turning_circle_is_within_the_reach():
    world, driver = packaged("world"), packaged("driverless")
    assert (
        world["speed"] / world["rate"] / driver["max_turn"]
        < driver["reach_distance"]
        < world["touch_distance"]
    )
