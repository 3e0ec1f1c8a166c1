"""The Gymnasium environments: one car, many cars, pictures, seeds, rewards and ends."""

import warnings
from pathlib import Path

import numpy as np
import pytest

gymnasium = pytest.importorskip(
    "gymnasium", reason="gymnasium is not installed (docker/prepare learning)"
)

from gymnasium.utils.env_checker import check_env

import sdc_experiments.learning  # noqa: F401
from sdc_experiments.learning.observation import ENTRIES, NAMES
from sdc_experiments.learning.train import drive, train

pytestmark = pytest.mark.slow(12)

SHORT = [{"straight_m": 30.0}]
LEARNING = Path(__file__).resolve().parents[4] / "docs" / "learning.md"


def entry(observation, name):
    return observation[..., NAMES.index(name)]


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("SdcTown-v0", {"route": SHORT}),
        ("SdcRandomRoutes-v0", {}),
        ("SdcScenario-v0", {"scenario": "traffic_lights"}),
        ("SdcTown-v0", {"route": SHORT, "observation": "camera"}),
    ],
)
def test_environment_passes_the_check_without_a_warning(name, arguments):
    arguments = {"picture_size": (64, 48), **arguments}
    environment = gymnasium.make(name, render_mode="rgb_array", **arguments)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(environment.unwrapped)


def test_seed_chooses_route_and_noise():
    environment = gymnasium.make(
        "SdcRandomRoutes-v0", sim_options={"odometry_noise": {"position_m": 0.1}}
    ).unwrapped

    def observed(seed):
        first, _ = environment.reset(seed=seed)
        steps = [environment.step(np.array([0.5, 0.0], np.float32)) for _ in range(20)]
        return np.array([first, *(step[0] for step in steps)]), environment._setup.waypoints_m

    first, route = observed(1)
    again, same_route = observed(1)
    other, other_route = observed(2)
    assert np.array_equal(first, again)
    assert np.array_equal(route, same_route)
    assert not np.array_equal(first, other)
    assert not np.array_equal(route, other_route)


def test_many_cars_see_and_earn_what_single_ones_do():
    random = np.random.default_rng(3)
    count = 4
    cars = gymnasium.make_vec("SdcTown-v0", count)
    singles = [gymnasium.make("SdcTown-v0").unwrapped for _ in range(count)]
    seen, _ = cars.reset(seed=0)
    assert np.allclose(seen, [single.reset(seed=0)[0] for single in singles])
    over = np.zeros(count, bool)
    for tick in range(160):
        if tick % 20 == 0:
            actions = random.uniform([0.2, -0.15], [0.8, 0.15], (count, 2)).astype(np.float32)
        seen, rewards, terminated, _, _ = cars.step(actions)
        for i, single in enumerate(singles):
            if not over[i]:
                one, reward, ended, _, _ = single.step(actions[i])
                np.testing.assert_allclose(seen[i], one, rtol=1e-5, atol=1e-5)
                assert (rewards[i], terminated[i]) == (pytest.approx(reward, abs=1e-9), ended)
        over |= terminated
    assert over.any()
    assert not over.all()


def test_car_starts_again_in_the_step_after_its_end():
    cars = gymnasium.make_vec("SdcTown-v0", 2, route=SHORT)
    cars.reset(seed=0)
    actions = np.array([[0.0, 0.0], [1.0, 1.0]], np.float32)
    terminated = np.zeros(2, bool)
    while not terminated.any():
        _, rewards, terminated, _, info = cars.step(actions)
    assert terminated.tolist() == [False, True]
    assert rewards[1] < -90.0
    seen, rewards, terminated, _, info = cars.step(actions)
    assert (info["s_m"][1], rewards[1], terminated[1]) == (0.0, 0.0, False)
    assert entry(seen[1], "speed_mps") == 0.0


def test_stop_at_the_end_of_the_route_is_rewarded():
    environment = gymnasium.make("SdcTown-v0", route=SHORT)
    seen, _ = environment.reset(seed=0)
    over, total = False, 0.0
    while not over:
        speed, limit = entry(seen, "speed_mps"), entry(seen, "speed_limit_2m_mps")
        pedals = np.clip(0.3 + 0.3 * (limit - speed) if limit > 0.0 else -1.0, -1.0, 1.0)
        seen, reward, over, truncated, info = environment.step(np.array([pedals, 0.0], np.float32))
        total += reward
        assert not truncated
    assert info["status"] == "completed"
    assert 100.0 + 25.0 / 0.5 < total < 100.0 + 30.0 / 0.5
    assert environment.observation_space.contains(seen)


@pytest.mark.parametrize(
    ("scenario", "at_m", "ahead_m"),
    # The other car is 60 m along the route and 4.7 m long, as the own one; the light is at 70 m.
    [
        ("stopped_car", 30.0, 30.0 - 4.7),
        ("traffic_lights", 50.0, 20.0 - 2.35),
        ("slalom", 1.0, 50.0),
    ],
)
def test_nearest_obstacle_or_red_light_is_observed(scenario, at_m, ahead_m):
    options = {"start": {"along_m": at_m}}
    environment = gymnasium.make("SdcScenario-v0", scenario=scenario, sim_options=options)
    seen, _ = environment.reset(seed=0)
    assert entry(seen, "obstacle_ahead_m") == pytest.approx(ahead_m, abs=0.01)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"observation": "lidar"}, "observation must be one of vector, camera, got 'lidar'"),
        ({"sim_options": {"frction": 1.0}}, "did you mean 'friction'"),
        ({"picture_size": (7, 7)}, "picture size 7 x 7 is not supported"),
    ],
)
def test_invalid_argument_is_named(arguments, message):
    with pytest.raises(ValueError, match="") as error:
        gymnasium.make("SdcTown-v0", **arguments)
    assert message in str(error.value)


def test_page_lists_every_entry_of_an_observation_and_the_example():
    page = LEARNING.read_text(encoding="utf-8")
    for name, _, _ in ENTRIES:
        assert f"`{name}`" in page or f"`{name.split('_')[0]}_" in page, name
    source = Path(sdc_experiments.learning.__file__).with_name("train.py").read_text("utf-8")
    assert f"```python\n{source}```" in page
    assert len(source.splitlines()) <= 60


def test_small_training_improves_the_policy():
    weights, curve = train(generations=3, policies=24, routes=1, ticks=100)
    assert curve[-1] > curve[0] + 5.0
    status, _ = drive(weights, seed=1000)
    assert status in ("completed", "off_road", "truncated")
