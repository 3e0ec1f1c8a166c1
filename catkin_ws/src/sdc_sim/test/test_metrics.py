import math

import numpy as np
import pytest

from sdc_sim.evaluation.metrics import (
    COEFFICIENTS,
    accelerations,
    comfort_breaks,
    drive_metrics,
    driving_score,
    off_lane_percent,
    peak_accelerations,
)

TIME_S = np.arange(0.0, 20.0, 0.05)


def test_metrics_of_a_drive_by_hand():
    """Every quarter of the drive has other errors, with both signs."""
    errors = np.repeat([0.4, -0.2, 0.1, -0.3], 25)
    columns = {"time_s": 0.05 * np.arange(100), "speed_mps": np.repeat([2.0, 4.0], 50)}
    columns.update(cross_track_m=errors, yaw_rad=np.zeros(100))
    columns["heading_error_rad"] = np.repeat([0.03, -0.01, 0.02, 0.0], 25)
    metrics = drive_metrics(columns, 100.0, dict.fromkeys(COEFFICIENTS, 0), 3.5)
    assert metrics["cross_track_rms_m"] == pytest.approx(math.sqrt(0.30 / 4.0))
    assert metrics["cross_track_max_m"] == 0.4
    assert metrics["heading_rms_rad"] == pytest.approx(math.sqrt(14e-4 / 4.0))
    assert (metrics["speed_mean_mps"], metrics["speed_max_mps"]) == (3.0, 4.0)
    assert (metrics["off_lane_percent"], metrics["driving_score"]) == (0.0, 100.0)
    assert metrics["infractions"] == dict.fromkeys(COEFFICIENTS, 0)
    assert metrics["comfortable"] is False


def test_off_lane_percent_is_a_share_of_the_distance_and_not_of_the_time():
    speed = np.where(TIME_S < 10.0, 10.0, 1.0)
    error = np.where(TIME_S < 10.0, 0.0, -2.0)
    assert off_lane_percent(TIME_S, speed, error, 3.5) == pytest.approx(1000.0 / 110.0, abs=0.5)
    assert off_lane_percent(TIME_S, speed, error, 4.1) == 0.0
    assert off_lane_percent(TIME_S, 0.0 * speed, error, 3.5) == 0.0


def test_driving_score_follows_the_leaderboard():
    names = "collision_pedestrian", "collision_vehicle", "collision_static", "red_light", "stop"
    none = dict.fromkeys(names, 0)
    assert driving_score(80.0, 0.0, none) == 80.0
    assert driving_score(80.0, 25.0, none) == 60.0
    each = driving_score(100.0, 0.0, dict.fromkeys(none, 1))
    assert each == pytest.approx(100.0 / (1.0 + 1.0 + 0.7 + 0.6 + 0.4 + 0.25))
    twice = driving_score(100.0, 50.0, {**none, "collision_pedestrian": 2})
    assert twice == pytest.approx(50.0 / 3.0)


@pytest.mark.parametrize(
    ("broken", "step_mps2", "for_s", "turn_radps"),
    [
        *(([], 2.3, 8.0, 0.0), (["longitudinal_acceleration_mps2"], 2.5, 8.0, 0.0)),
        *(([], -3.9, 4.0, 0.0), (["longitudinal_acceleration_mps2"], -4.2, 4.0, 0.0)),
        (["lateral_acceleration_mps2"], 0.0, 0.0, 0.26),
        (["yaw_rate_radps", "lateral_acceleration_mps2"], 0.0, 0.0, 1.0),
        (["longitudinal_jerk_mps3", "longitudinal_acceleration_mps2"], -6.0, 0.9, 0.0),
    ],
)
def test_comfort_has_the_limits_of_nuplan(broken, step_mps2, for_s, turn_radps):
    """The car changes its acceleration slowly, except for a short push."""
    ramp_s = 2.0 if for_s > 1.0 else 0.05
    ramp = np.minimum(TIME_S - 5.0, 5.0 + for_s + ramp_s - TIME_S) / ramp_s
    speed = 20.0 + 0.05 * step_mps2 * np.cumsum(np.clip(ramp, 0.0, 1.0))
    assert comfort_breaks(TIME_S, speed, turn_radps * TIME_S) == sorted(broken)
    assert comfort_breaks(TIME_S[:20], speed[:20], 0.0 * TIME_S[:20]) is None


def test_uneven_time_steps_give_the_same_accelerations():
    uneven_s = np.sort(np.concatenate([TIME_S, TIME_S + 0.013]))
    for time_s in (TIME_S, uneven_s):
        values = peak_accelerations(time_s, 3.0 * time_s, 0.1 * time_s)
        assert values["longitudinal_acceleration_max_mps2"] == pytest.approx(3.0, rel=1e-6)
        greatest = values["lateral_acceleration_max_mps2"]
        assert greatest == pytest.approx(0.1 * 3.0 * time_s[-1], rel=0.02)


def test_lateral_acceleration_is_right_where_yaw_wraps():
    yaw = np.mod(0.5 * TIME_S + math.pi, 2.0 * math.pi) - math.pi
    found = peak_accelerations(TIME_S, np.full_like(TIME_S, 4.0), yaw)
    assert found["lateral_acceleration_max_mps2"] == pytest.approx(2.0)


def test_no_slope_is_computed_across_a_gap():
    keep = (TIME_S < 5.0) | (TIME_S > 8.0)
    speed = np.where(TIME_S < 5.0, 2.0, 12.0)
    values = peak_accelerations(TIME_S[keep], speed[keep], np.zeros(keep.sum()))
    assert values["longitudinal_acceleration_max_mps2"] == pytest.approx(0.0, abs=1e-9)
    assert len(accelerations(TIME_S[keep], speed[keep], np.zeros(keep.sum()))) == 2
