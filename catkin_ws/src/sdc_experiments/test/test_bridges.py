"""Drives over a bridge and below it: who is on the other level does not matter."""

import math

import numpy as np
import pytest

from sdc_experiments.closed_loop import drive_result
from sdc_testing.street_maps import bridge, needs_maps, needs_traffic

pytestmark = [needs_maps, pytest.mark.slow(6)]

# Standing cars: on the bridge, and below it, where the car drives.
_ABOVE = "{kind: car, at: [-1.75, 1.75], yaw_rad: 3.1416}"
_BELOW = "{kind: car, at: [1.75, -1.75], yaw_rad: 1.5708}"
# A column that drives on the other level, of which one is at the crossing when the car is there.
_PATH = "{{kind: car, path: [[1.75, {}.0], [1.75, 90.0]], speed_mps: 8.0}}"
_DRIVE_BELOW = ", ".join(map(_PATH.format, range(-110, -30, 6)))
# Start and goal of the way over the bridge [m].
_OVER = ((-75.0, -1.75), (90.0, -1.75))
# Start and goal of the way below it [m].
_UNDER = ((-1.75, 60.0), (-1.75, -90.0))


@pytest.fixture(scope="module", name="path")
def _path(tmp_path_factory):
    return bridge(tmp_path_factory.mktemp("bridge"))


def driven(folder, path, ends, obstacles, **arguments):
    """Return the evaluation of a drive, and the true states of its ticks."""
    scenario, seen = folder / "scenario.yaml", []
    scenario.write_text(
        f"about: a bridge\nframe: map\nmap: {path}\ngoals: [[{ends[1][0]}, {ends[1][1]}]]\n"
        f"obstacles: [{', '.join(obstacles)}]\n"
    )
    start = {"start": ends[0], "observe": seen.append}
    return drive_result(str(scenario), map=path, **start, **arguments), seen


@pytest.mark.parametrize(
    ("ends", "obstacle"), [(_OVER, _BELOW), (_OVER, _DRIVE_BELOW), (_UNDER, _ABOVE)]
)
def test_car_drives_on_as_if_the_other_level_were_empty(tmp_path, path, ends, obstacle):
    free, _ = driven(tmp_path, path, ends, [])
    result, seen = driven(tmp_path, path, ends, [obstacle])
    assert result.metrics["status"] == "completed" and result.metrics["driving_score"] == 100.0
    assert result.rows.tolist() == free.rows.tolist()
    pairs = ((one.state, other) for one in seen for other in one.obstacles)
    assert min(math.dist((one.x_m, one.y_m), (other.x_m, other.y_m)) for one, other in pairs) < 3.5


@pytest.mark.parametrize(
    ("ends", "place"),
    [(_OVER, "[0.0, -1.75], yaw_rad: 0.0"), (_UNDER, "[-1.75, 0.0], yaw_rad: 4.7")],
)
def test_car_reacts_to_one_on_its_own_level(tmp_path, path, ends, place):
    result, _ = driven(tmp_path, path, ends, [f"{{kind: car, at: {place}}}"], longest_s=12.0)
    assert "obstacle" in result.reasons or np.abs(result.rows[:, 6]).max() > 1.0
    assert result.metrics["infractions"]["collision_vehicle"] == 0


@needs_traffic
def test_car_among_traffic_of_both_levels_meets_nobody(path):
    seen = []
    ends = {"start": (-190.0, -1.75), "goal": (90.0, -1.75)}
    result = drive_result(map=path, seed=1, traffic=20, observe=seen.append, **ends)
    assert result.metrics["status"] == "completed" and result.metrics["driving_score"] == 100.0
    heights_m = [other.z_m for one in seen for other in one.obstacles]
    assert min(heights_m) < 0.1 and max(heights_m) > 5.9
    slope = [one for one in seen if -130.0 < one.state.x_m < -90.0]
    assert {round(one.pitch_rad, 3) for one in slope} == {-0.1}
    assert all(abs(one.z_m - 0.1 * (one.state.x_m + 140.0)) < 0.02 for one in slope)
