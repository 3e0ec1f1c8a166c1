"""Towns that are drawn from a seed."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components
from test_drivable import assert_routes_are_drivable
from test_mirror import assert_is_mirror_image

from sdc_map import random_town
from sdc_map.map_file import map_file, town_seeds
from sdc_map.network import STOP
from sdc_map.network_file import MapError, load_network
from sdc_testing.street_maps import needs_maps

pytestmark = needs_maps


@pytest.fixture(name="cache", autouse=True)
def _cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


def assert_is_town(seed):
    """Assert that a town is connected, without folds, and its lights and stop signs are safe."""
    network = load_network(f"random:{seed}")
    numbers = {lane.id: number for number, lane in enumerate(network.driving)}
    leads = [
        (numbers[lane.id], numbers[name])
        for lane in network.driving
        for name in (*lane.successors, lane.left, lane.right)
        if name in numbers
    ]
    graph = csr_matrix((np.ones(len(leads)), tuple(zip(*leads))), (len(numbers),) * 2)
    assert connected_components(graph, connection="strong")[0] == 1, seed
    for junction in network.junctions.values():
        assert_lights_are_safe(junction)
        stops = {one.start for one in junction.connections if one.line == STOP}
        assert all(one.line == STOP for one in junction.connections if one.start in stops)
    assert_routes_are_drivable(network, 6)
    return network


def assert_lights_are_safe(junction):
    """Assert that two ways that must not meet have no green together, and yellow before red."""
    for (duration_s, state), (_, after) in zip(
        junction.phases, [*junction.phases[1:], *junction.phases[:1]]
    ):
        assert duration_s >= 3.0 or "y" not in state
        lit = [one for one in junction.connections if one.signal >= 0]
        assert not any(state[one.signal] in "gG" and after[one.signal] == "r" for one in lit)
        green = [one for one in lit if state[one.signal] == "G"]
        for one in green:
            assert not any(junction.connections[other] in green for other in one.gives_way_to)


@pytest.mark.slow(5)
def test_towns_load_and_are_connected():
    first, other = assert_is_town(1), assert_is_town(2)
    assert len(first.driving) != len(other.driving)


@pytest.mark.slow(2)
def test_same_seed_draws_the_same_bytes(tmp_path, monkeypatch):
    with open(map_file("random:4"), "rb") as file:
        first = file.read()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "other"))
    with open(map_file("random", seed=4), "rb") as file:
        assert file.read() == first
    assert b"generated" not in first


@pytest.mark.slow(3)
def test_left_hand_towns_are_mirrored(tmp_path, monkeypatch):
    right = map_file("random:9")
    monkeypatch.setattr(random_town, "_LEFT_HAND_SHARE", 1.0)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "left"))
    left = map_file("random:9")
    assert_is_mirror_image(load_network(left), load_network(right))
    assert load_network(left).net_path.startswith(str(tmp_path / "left"))


@pytest.mark.nightly
def test_a_hundred_towns_are_connected_without_folds_and_have_all_kinds_of_places():
    kinds, limits_kmh, crosswalks, rings, sides = set(), set(), 0, 0, []
    for seed in range(100):
        network = assert_is_town(seed)
        kinds |= {one.kind for one in network.junctions.values() if len(one.connections) > 2}
        streets = [one for one in network.driving if not one.junction]
        limits_kmh |= {round(3.6 * one.speed_limit_mps) for one in streets}
        crosswalks += len(network.crosswalks)
        sides.append(network.y_sign)
        rings += sum(one.id.startswith("r") and one.id.endswith("_0_0") for one in streets)
    assert kinds >= {"traffic_light", "priority", "priority_stop", "right_before_left"}
    assert limits_kmh == {30, 50, 60, 70, 80, 100, 120}
    assert crosswalks > 500 and rings > 20
    assert 10 < sides.count(-1.0) < 40


@pytest.mark.parametrize("name", ["random", "random:", "random:x", "random:1-4", "random:-1"])
def test_name_that_is_not_one_town_is_one_line_with_the_fix(name):
    with pytest.raises(MapError, match=f"^{name}: is not one town; write random:SEED") as error:
        load_network(name)
    assert "\n" not in str(error.value)


def test_seed_that_is_too_large_is_refused():
    with pytest.raises(MapError, match="^random:4294967296: the seed must be at most 4294967295$"):
        load_network("random:4294967296")


def test_set_of_towns():
    assert town_seeds("random:3-5") == [3, 4, 5]
    assert town_seeds("random:3") == town_seeds("town") == []
    with pytest.raises(MapError, match="^random:5-3: has no town; write random:FIRST-LAST"):
        town_seeds("random:5-3")
