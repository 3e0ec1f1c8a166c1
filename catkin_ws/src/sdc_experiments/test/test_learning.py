"""The Gymnasium environments: one car, many cars, pictures, seeds, rewards and ends."""

import warnings
from pathlib import Path

import numpy as np
import pytest

gymnasium = pytest.importorskip(
    "gymnasium", reason="gymnasium is not installed (docker/prepare learning)"
)

from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import sdc_experiments.learning  # noqa: F401
from sdc_common.machine_code import numba_module
from sdc_experiments.learning import merge, traffic_world
from sdc_experiments.learning.observation import NAMES
from sdc_experiments.learning.traffic_environment import TRAFFIC_NAMES
from sdc_experiments.learning.train import drive, train
from sdc_testing.street_maps import needs_maps

pytestmark = pytest.mark.slow(12)

# A road of 30 m.
SHORT = [{"straight_m": 30.0}]
# When an environment begins again.
MODES = [*AutoresetMode]
NEXT_STEP = AutoresetMode.NEXT_STEP
ON_STREETS = {"map": "town", "sim_options": {"street_scenario": "ParkingCutIn"}}
LEARNING = Path(__file__).resolve().parents[4] / "docs" / "learning.md"


def entry(observation, name):
    return observation[..., NAMES.index(name)]


def pedals_for(observation):
    """Return the pedals that keep the speed limit and stop at the end of the route."""
    speed, limit = entry(observation, "speed_mps"), entry(observation, "speed_limit_2m_mps")
    return np.clip(0.3 + 0.3 * (limit - speed) if limit > 0.0 else -1.0, -1.0, 1.0)


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("SdcTown-v0", {"route": SHORT}),
        ("SdcRandomRoutes-v0", {}),
        ("SdcScenario-v0", {"scenario": "traffic_lights"}),
        ("SdcTown-v0", {"route": SHORT, "observation": "camera"}),
        ("SdcTraffic-v0", {"others": 10}),
        pytest.param("SdcScenario-v0", ON_STREETS, marks=needs_maps),
    ],
)
def test_environment_passes_the_check_without_a_warning(name, arguments):
    if name != "SdcTraffic-v0":
        arguments = {"picture_size": (64, 48), **arguments}
    environment = gymnasium.make(name, render_mode="rgb_array", **arguments)
    numba_module()  # Its own import warns.
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

    first, again, other = observed(1), observed(1), observed(2)
    assert all(map(np.array_equal, first, again))
    assert not any(map(np.array_equal, first, other))


@pytest.mark.parametrize(
    "mode",
    [pytest.param(one, marks=() if one == NEXT_STEP else pytest.mark.nightly) for one in MODES],
    ids=lambda mode: mode.value,
)
def test_vector_environment_behaves_as_gymnasiums_own(mode):
    """Four cars drive off the road, come to its end, stand still and drive on."""
    arguments = {"route": [{"straight_m": 60.0}], "render_mode": "rgb_array"}
    arguments["picture_size"] = 64, 48
    cars = gymnasium.make_vec("SdcTown-v0", 4, autoreset_mode=mode, **arguments)
    arguments.update(vectorization_mode="sync", vector_kwargs={"autoreset_mode": mode})
    own = gymnasium.make_vec("SdcTown-v0", 4, **arguments)
    assert cars.metadata["autoreset_mode"] is own.metadata["autoreset_mode"] is mode
    step = cars.reset(seed=0)
    agree(step, own.reset(seed=0))
    statuses = set()
    for _ in range(300):
        actions = [[0.8, 1.0], [pedals_for(step[0][1]), 0.0], [-1.0, 0.0], [0.4, -0.01]]
        step = cars.step(actions)
        agree(step, own.step(np.array(actions, np.float32)))
        ended = step[2] | step[3]
        infos = step[4].get("final_info", step[4])
        statuses |= set(infos["status"][ended & infos["_status"]])
        if mode is AutoresetMode.DISABLED and ended.any():
            with pytest.raises(gymnasium.error.ResetNeeded):
                cars.step(actions)
            agree(*(one.reset(options={"reset_mask": ended}) for one in (cars, own)), ended)
    assert statuses == {"off_road", "completed", ""}
    for picture, expected in zip(cars.render(), own.render()):
        np.testing.assert_allclose(picture, expected, atol=2)


def test_worlds_in_traffic_are_those_of_single_environments():
    """One car merges, one stays on the ramp, one leaves the road, one hits another one."""
    options = {"id": "SdcTraffic-v0", "num_envs": 4, "render_mode": "rgb_array"}
    cars = gymnasium.make_vec(**options)
    own = gymnasium.make_vec(vectorization_mode="sync", **options)
    weights = np.tile(merge.FIRST, (4, 1))
    weights[1, 0] = -1.0
    step = cars.reset(seed=[5, 6, 7, 3])
    agree(step, own.reset(seed=[5, 6, 7, 3]))
    ends = set()
    for _ in range(450):
        actions = merge.act(weights, step[0])
        actions[2] = 0.4, 0.02
        step = cars.step(actions)
        agree(step, own.step(actions))
        ends |= {*zip(step[4]["status"], [0, 1, 2, 3])}
    assert {("completed", 0), ("off_road", 1), ("off_road", 2), ("collision", 3)} <= ends
    assert all(np.array_equal(*pictures) for pictures in zip(cars.render(), own.render()))


@pytest.mark.parametrize("left_m", [0.0, 1.6])
def test_other_cars_follow_change_lanes_and_make_way(left_m):
    """A slow car of ours is not touched; one that is in both lanes is not overtaken."""
    cars, number = np.zeros((1, 6, 40)), np.arange(40)
    cars[0, traffic_world.S] = 30.0 * number
    cars[0, traffic_world.LANE] = 1 + number % 2
    cars[0, traffic_world.Y] = 3.5 * (number % 2)
    cars[0, traffic_world.SPEED] = 15.0
    cars[0, traffic_world.WISH], cars[0, traffic_world.TIME_GAP] = 28.0, 1.2
    order, near, hits = number[None].copy(), np.zeros((1, 3, 4)), np.zeros(1, bool)
    lanes, least_m = [], 100.0
    cars[0, traffic_world.LANE, -1], cars[0, traffic_world.Y, -1] = 1.0, left_m
    for tick in range(1200):
        cars[0, traffic_world.S, -1] = (cars[0, traffic_world.S, -1] + 0.05 * 12.0) % 1200.0
        cars[0, traffic_world.SPEED, -1] = 12.0
        traffic_world.move_others(cars, order, 3, [tick], 0.05, 0, 1)
        traffic_world.look_around(cars, near, hits, 0, 1)
        least_m = min(least_m, near[0, 1, 2])
        assert not hits[0]
        lanes.append(cars[0, traffic_world.LANE].copy())
        for lane in (1, 2):
            along = np.sort(cars[0, traffic_world.S][lanes[-1] == lane])
            assert np.diff(along, append=along[0] + 1200.0).min() > 4.7
    assert 2.0 < least_m < 40.0
    changes = np.diff(lanes, axis=0)
    assert left_m or (np.any(changes > 0.0) and np.any(changes < 0.0))
    assert 11.0 < cars[0, traffic_world.SPEED, :-1].mean() < 28.0


def test_training_teaches_to_merge():
    policy = merge.train(generations=2, policies=12, worlds=16)
    drives = [merge.drive(one[None], 60, 9000)[1] for one in (merge.FIRST, policy)]
    rates = [np.mean(statuses == "completed") for statuses in drives]
    assert rates[0] < 0.6 and rates[1] > rates[0] + 0.2


def agree(first, second, cars=slice(None)):
    """Compare what reset or step of two vector environments returned; info for some of the cars."""
    *arrays, info = first
    *expected, expected_info = second
    for one, other in zip(arrays, expected):
        np.testing.assert_allclose(one, other, rtol=1e-5, atol=1e-5)
    for name, values in expected_info.items():
        if name == "final_info":
            agree((info[name],), (values,), info["_final_info"])
        elif name == "final_obs":
            agree(([*info[name][info["_" + name]]], {}), ([*values[info["_" + name]]], {}))
        elif values.dtype == object or values.dtype == bool:
            assert info[name][cars].tolist() == values[cars].tolist(), name
        else:
            np.testing.assert_allclose(info[name][cars], values[cars], rtol=1e-5, atol=1e-5)


def test_seeds_choose_the_same_routes_in_both_kinds_of_vector_environment():
    cars = gymnasium.make_vec("SdcRandomRoutes-v0", 3)
    own = gymnasium.make_vec("SdcRandomRoutes-v0", 3, vectorization_mode="sync")
    seen = []
    for seed in (5, [9, 8, 7]):
        agree(cars.reset(seed=seed), own.reset(seed=seed))
        for _ in range(40):
            step = cars.step(np.full((3, 2), [0.6, 0.0]))
            agree(step, own.step(np.full((3, 2), [0.6, 0.0], np.float32)))
        seen.append(step[0])
    assert not np.allclose(*seen)
    # The second car alone gets another route; the others drive on.
    mask = np.array([False, True, False])
    one, other = (two.reset(seed=3, options={"reset_mask": mask}) for two in (cars, own))
    agree(one, other, mask)
    for _ in range(40):
        step = cars.step(np.full((3, 2), [0.6, 0.0]))
        agree(step, own.step(np.full((3, 2), [0.6, 0.0], np.float32)))


def test_stop_at_the_end_of_the_route_is_rewarded():
    environment = gymnasium.make("SdcTown-v0", route=SHORT)
    seen, _ = environment.reset(seed=0)
    over, total = False, 0.0
    while not over:
        seen, reward, over, truncated, info = environment.step([pedals_for(seen), 0.0])
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


@needs_maps
def test_each_reset_draws_another_place_of_a_scenario_type():
    environment = gymnasium.make("SdcScenario-v0", **ON_STREETS)

    def drive_from(**seed):
        environment.reset(**seed)
        return [environment.step(np.array([0.5, 0.0]))[0][:21] for _ in range(60)]

    first, another, again = drive_from(seed=1), drive_from(), drive_from(seed=1)
    assert np.array_equal(first, again) and not np.array_equal(first, another)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"observation": "lidar"}, "observation must be one of vector, camera, got 'lidar'"),
        ({"sim_options": {"frction": 1.0}}, "did you mean 'friction'"),
        ({"picture_size": (7, 7)}, "picture size 7 x 7 is not supported"),
        ({"id": "SdcTraffic-v0", "lanes": 0}, "lanes must be at least 1, got 0"),
        ({"id": "SdcTraffic-v0", "others": 200}, "others must be 0 to 127 on 2 lanes, got 200"),
    ],
)
def test_invalid_argument_is_named(arguments, message):
    with pytest.raises(ValueError, match="") as error:
        gymnasium.make(**{"id": "SdcTown-v0", **arguments})
    assert message in str(error.value)


@pytest.mark.parametrize("name", ["SdcTown-v0", "SdcRandomRoutes-v0", "SdcTraffic-v0"])
def test_wrong_batch_is_refused_before_anything_moves(name):
    cars, other = (gymnasium.make_vec(name, 3, threads=1) for _ in range(2))
    right = np.tile(np.float32([1.0, 0.0]), (3, 1))
    with pytest.raises(ValueError, match="before the first reset"):
        cars.step(right)
    for seed in ([1, 2], [1, 2, 3, 4], []):
        with pytest.raises(ValueError, match=f"a list of 3, got {len(seed)} seeds"):
            cars.reset(seed=seed)
    cars.reset(seed=1), other.reset(seed=1)
    for shape in ((1, 2), (2, 2), (5, 2), (2, 3), (6,), (3, 2, 1), (3, 0)):
        with pytest.raises(ValueError, match=r"actions must have the shape \(3, 2\), not"):
            cars.step(np.ones(shape, np.float32))
    for value in (np.nan, np.inf):
        wrong = right.copy()
        wrong[2, 1] = value
        with pytest.raises(ValueError, match=f"must be finite, got {value}"):
            cars.step(wrong)
    for mask in ([True, False], np.ones((3, 1), bool), [1, 0, 1]):
        with pytest.raises(ValueError, match="reset_mask must be"):
            cars.reset(options={"reset_mask": np.array(mask)})
    assert all(map(np.array_equal, cars.step(right)[:4], other.step(right)[:4]))


@pytest.mark.parametrize("name", ["SdcTown-v0", "SdcTraffic-v0"])
def test_wrong_action_of_one_car_is_refused(name):
    car = gymnasium.make(name).unwrapped
    with pytest.raises(ValueError, match="before the first reset"):
        car.step([0.5, 0.0])
    car.reset(seed=1)
    for action in ([0.5], [0.5, 0.0, 0.0], [[0.5, 0.0]], 0.5, [[0.5], [0.0]]):
        with pytest.raises(ValueError, match=r"action must have the shape \(2,\), not"):
            car.step(np.array(action, np.float32))
    with pytest.raises(ValueError, match="action must be finite, got nan"):
        car.step(np.array([np.nan, 0.0]))


def test_window_shows_what_the_camera_sees(monkeypatch):
    pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    with pytest.warns(UserWarning, match="human"):
        car = gymnasium.make("SdcTraffic-v0", render_mode="human")
    car.reset(seed=1)
    car.step(np.zeros(2, np.float32))
    shown = car.unwrapped.render()
    assert shown.shape[2] == 3 and shown.std() > 1.0
    car.close()


def test_page_lists_every_entry_of_an_observation_and_the_example():
    page = LEARNING.read_text(encoding="utf-8")
    for name in (*NAMES, *TRAFFIC_NAMES):
        assert f"`{name}`" in page or f"`{name.split('_')[0]}_" in page, name
    source = Path(sdc_experiments.learning.__file__).with_name("train.py").read_text("utf-8")
    assert f"```python\n{source}```" in page
    assert len(source.splitlines()) <= 60


def test_small_training_improves_the_policy():
    weights, curve = train(generations=3, policies=24, routes=1, ticks=100)
    assert curve[-1] > curve[0] + 5.0
    status, _ = drive(weights, seed=1000)
    assert status in ("completed", "off_road", "truncated")
