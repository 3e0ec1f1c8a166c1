"""What the evaluated drive contains, apart from its metrics."""

import math

import numpy as np
import pytest
from referee_rules import RULES, TICK_NS, with_route

from sdc_sim.physics.traffic_lights import GREEN, RED


def drive_on(evaluator, first, last, speed=1.0):
    """Drive at a speed [m/s] along the route in the ticks from the first to the last."""
    for tick in range(first, last + 1):
        evaluator.add("odometry", tick * TICK_NS, 0.05 * speed * tick, 0.2, 0.0, speed)
        evaluator.add("command", tick * TICK_NS, 0.0005 * tick, 0.0, -0.1)


def test_result_holds_what_was_planned_photographed_and_seen():
    evaluator = with_route()
    evaluator.add("planned", 9.0)  # before the first odometry: at no place
    evaluator.add("stop_lines", [(7, 50.0, 0.0, 1.75)])
    drive_on(evaluator, 1, 2, speed=10.0)
    evaluator.add("planned", 4.0)
    evaluator.add("snapshot", 0.1, 1.0, "YSBwaWN0dXJl")
    evaluator.add("lights", 2 * TICK_NS, [(7, RED)])
    evaluator.add("lights", 0, [(7, GREEN)])
    result = evaluator.result()
    np.testing.assert_allclose(result.planned, [[1.0, 4.0, 0.1]])
    assert result.snapshots == [(0.1, 1.0, "YSBwaWN0dXJl")]
    assert result.scene["lights"] == [(0.1, {7: RED}), (0.1, {7: GREEN})]
    assert list(result.stop_lines) == [7]
    assert result.ideal.speed_mps.shape == (len(evaluator.drive.route.points),)
    assert result.ideal.speed_mps.max() == pytest.approx(RULES.speed_limits().cruise_mps, rel=0.5)


def test_result_counts_the_answers_by_stamp_and_by_order():
    evaluator = with_route()
    drive_on(evaluator, 1, 3)
    evaluator.add("odometry", 4 * TICK_NS, 0.2, 0.2, 0.0, 1.0)
    evaluator.add("command", 0, 0.5, 0.0, 0.0)
    metrics = evaluator.result().metrics
    assert (metrics["ticks_by_stamp"], metrics["ticks_by_order"]) == (3, 1)
    assert metrics["assumed_limits"] == list(RULES.assumed)


def test_error_of_the_camera_is_that_at_the_stamps_of_its_pictures():
    evaluator = with_route()
    drive_on(evaluator, 1, 40)
    assert "lane_offset_rms_error_m" not in evaluator.result().metrics
    for tick, offset_m in ((2, 0.3), (3, 0.1), (4, math.nan), (39, 9.0), (50, 9.0)):
        evaluator.add("lane_offset", tick * TICK_NS, offset_m)
    metrics = evaluator.result().metrics
    assert metrics["lane_offset_rms_error_m"] == pytest.approx(0.1), "the car is at 0.2 m"


def test_each_time_without_odometry_is_added():
    evaluator = with_route()
    for first in (1, 40, 80):
        drive_on(evaluator, first, first + 9)
    assert evaluator.result().metrics["unseen_s"] == pytest.approx((30 + 31) * 0.05)


@pytest.mark.parametrize(
    ("stamps", "accepted"),
    [([1, 1, 2, 80], [1, 2, 80]), ([200, 198, 201, 199, 202], [200, 201, 202])],
    ids=["repeated", "second publisher"],
)
def test_odometry_that_is_not_newer_is_ignored(stamps, accepted):
    evaluator = with_route()
    found = [n for n in stamps if evaluator.add("odometry", n * TICK_NS, 0.0, 0.0, 0.0, 1.0)]
    assert found == accepted
    assert evaluator.result().metrics["ticks"] == len(accepted)


def test_nothing_counts_after_the_end():
    evaluator = with_route()
    evaluator.add("stop_lines", [(7, 50.0, 0.0, 1.75)])
    drive_on(evaluator, 1, 100, speed=9.5)
    evaluator.add("collision", 95 * TICK_NS, 0)
    assert evaluator.over
    before = evaluator.result().metrics
    drive_on(evaluator, 101, 110, speed=9.5)
    evaluator.add("lights", 100 * TICK_NS, [(7, RED)])
    evaluator.add("collision", 105 * TICK_NS, 3)
    evaluator.add("planned", 1.0)
    assert evaluator.result().metrics == before
    assert len(evaluator.result().planned) == 0
    assert not evaluator.add("odometry", 111 * TICK_NS, 50.0, 0.0, 0.0, 1.0)
