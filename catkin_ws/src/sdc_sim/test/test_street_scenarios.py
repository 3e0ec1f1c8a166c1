"""Scenario types: their table, their places in the town, and what the world makes of them."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from sdc_common.geometry.polyline import Polyline
from sdc_common.validation import DocumentError
from sdc_map.network_file import load_network
from sdc_sim.evaluation.lane_rules import holds_up
from sdc_sim.evaluation.street_rules import RoadUser
from sdc_sim.physics.collision import Rectangle, overlap
from sdc_sim.physics.obstacles import KINDS
from sdc_sim.scenario.drive_setup import drive_setup
from sdc_sim.scenario.map_drive import first_mission
from sdc_sim.scenario.street_scenarios import place, types
from sdc_testing.street_maps import needs_maps

pytestmark = needs_maps
SEEDS = (0, 1)
ABILITIES = {"Merging", "Overtaking", "Emergency_Brake", "Give_Way", "Traffic_Signs"}
NAIVE = {"obstacles", "lights", "signs", "behaviour", "speed"}
OWN_KEYS = {"about", "abilities", "naive", "place"}
KEYS = OWN_KEYS | {"light", "parameters", "extra_s", "actors"}
ACTOR_KEYS = {
    *("kind", "way", "at_m", "along_m", "from_start_m", "from_line_m", "comes_s", "left_m"),
    *("to_left_m", "over_m", "mps", "of_limit", "steps", "within_m", "within_s", "meets_s"),
    *("count", "gaps_s", "gap_m", "turned_deg", "size_m", "looks", "from_m", "to_m", "meets_mps"),
}


@pytest.fixture(scope="module", name="town")
def _town():
    return load_network("town")


def bodies_of(placement):
    for actor in placement.actors:
        if actor.start_m >= 0.0:
            line = Polyline(actor.path_m.tolist())
            yaw = line.heading_at(actor.start_m) + actor.turned_rad
            yield Rectangle(*line.point_at(actor.start_m), yaw, *actor.size_m[:2])


def test_table_has_the_types_of_carla_and_bench2drive_and_no_unknown_key():
    table = types()
    assert len(table) == 46
    for name, row in table.items():
        assert OWN_KEYS <= {*row} <= KEYS, name
        assert {*row["abilities"]} <= ABILITIES and row["naive"] in NAIVE, name
        assert row["about"].endswith("."), name
        if "light" in row:
            assert row["light"] in ("green", "red"), name
        for group in row.get("actors", ()):
            for actor in group if isinstance(group, list) else [group]:
                assert {*actor} <= ACTOR_KEYS, name
                kinds = actor["kind"] if isinstance(actor["kind"], list) else [actor["kind"]]
                assert {*kinds} <= {*KINDS}, name


def test_page_has_the_table():
    page = Path(__file__).resolve().parents[4] / "docs" / "scenarios.md"
    if not page.exists():
        pytest.skip("outside the repository")
    shown = re.findall(r"\| `(\w+)` \| (.*?) \| (.*?) \| (\w+) \|", page.read_text("utf-8"))

    def abilities(row):
        return ", ".join(row["abilities"]).replace("_", " ").lower() or "-"

    rows = types().items()
    assert shown == [(name, row["about"], abilities(row), row["naive"]) for name, row in rows]


@pytest.mark.slow(5)
@pytest.mark.parametrize("name", types())
def test_type_is_placed_in_the_town_the_same_each_time(town, name):
    drawn = set()
    for seed in SEEDS:
        placed, again = place(name, town, seed), place(name, town, seed)
        assert (placed.start, placed.goals) == (again.start, again.goals)
        assert placed.lights_s == again.lights_s
        assert len(placed.actors) == len(again.actors)
        for actor, same in zip(placed.actors, again.actors):
            assert (actor.kind, actor.start_m, actor.steps) == (same.kind, same.start_m, same.steps)
            assert np.array_equal(actor.path_m, same.path_m)
        length_m = len(placed.mission_m)
        event_at_m = Polyline(placed.mission_m.tolist()).nearest(*placed.event_m).s_m
        assert 90.0 < length_m < 420.0 and 30.0 < event_at_m < length_m - 40.0
        assert math.dist(placed.mission_m[0], placed.start) < 0.1
        assert math.dist(placed.mission_m[-1], placed.goals[0]) < 1.0
        drawn.add((placed.start, event_at_m, *[actor.start_m for actor in placed.actors]))
        options = {"map_path": "town", "street_scenario": name, "seed": seed}
        world = drive_setup(route=placed.mission_m, options=options).simulation()
        bodies = [world.outline.grown(0.2), *bodies_of(placed)]
        for number, body in enumerate(bodies):
            assert not any(overlap(body, other) for other in bodies[:number]), (seed, number)
        for actor in placed.actors:
            if actor.gaps_s and name != "ParkingExit":  # no flow comes over the start of the car
                assert np.hypot(*(actor.path_m - placed.start).T).min() > 2.0, (seed, actor.kind)
    if placed.actors:
        assert len(drawn) > 1


@pytest.mark.parametrize(
    "name",
    ["ParkingExit", "HazardAtSideLane", "HighwayExit", "SignalizedJunctionLeftTurn"]
    + ["MergerIntoSlowTraffic"],
)
def test_type_with_traffic_on_the_left_is_the_mirror_image(town, name):
    left, right = place(name, load_network("town_left"), 0), place(name, town, 0)
    flip = (1.0, -1.0)
    points = [left.start, left.event_m, *left.goals]
    assert np.multiply(points, flip).tolist() == [
        [*one] for one in (right.start, right.event_m, *right.goals)
    ]
    assert np.array_equal(left.mission_m * flip, right.mission_m)
    assert len(left.actors) == len(right.actors)
    for one, other in zip(left.actors, right.actors):
        assert np.array_equal(one.path_m * flip, other.path_m)
        assert (one.start_m, one.turned_rad) == (other.start_m, -other.turned_rad)
    ways = ({id(one.path_m) for one in side.actors} for side in (left, right))
    assert len({*map(len, ways)}) == 1


@pytest.mark.slow(2)
@pytest.mark.parametrize("name", ["InterurbanActorFlow", "InterurbanAdvancedActorFlow"])
def test_flow_comes_into_the_world_long_before_the_junction(town, name):
    for seed in range(1, 30):
        placement = place(name, town, seed)
        assert placement.actors, seed
        for actor in placement.actors:
            line = Polyline(actor.path_m.tolist())
            assert line.nearest(*placement.event_m).s_m > 5.0 * actor.speed_mps, seed


def test_world_has_road_users_conditions_and_lights_of_the_type(town):
    placed = place("SignalizedJunctionLeftTurn", town, 2)
    options = {"map_path": "town", "street_scenario": "SignalizedJunctionLeftTurn", "seed": 2}
    world = drive_setup(route=placed.mission_m, options=options).simulation()
    plain = drive_setup(route=placed.mission_m, options={"map_path": "town"}).simulation()
    assert len(world.snapshot.obstacles) == sum(actor.start_m >= 0.0 for actor in placed.actors)
    shift_s = {a.offset_s - b.offset_s for a, b in zip(world.lights, plain.lights)}
    assert shift_s == {placed.lights_s}
    slippery = place("ControlLoss", town, 1)
    options.update(street_scenario="ControlLoss", seed=1)
    world = drive_setup(route=slippery.mission_m, options=options).simulation()
    assert world.vehicle.friction == slippery.parameters["friction"] < 0.5


def test_mistakes_are_one_line_that_names_the_fix(town):
    with pytest.raises(
        ValueError, match="unknown type 'Acident'; did you mean 'Accident'"
    ) as error:
        place("Acident", town, 0)
    assert "\n" not in str(error.value)
    with pytest.raises(ValueError, match="Accident has its own start and goal; remove"):
        first_mission(None, (0.0, 0.0), [], 0, "Accident")
    with pytest.raises(DocumentError, match=r"street_scenario: .* name a map \(map:=FILE\)"):
        drive_setup(options={"street_scenario": "Accident"}).simulation()


def test_map_without_such_a_place_is_named(small_map):
    with pytest.raises(ValueError, match="the map small has no place for HighwayExit; choose"):
        place("HighwayExit", small_map, 0)


@pytest.fixture(name="small_map")
def _small_map(town):
    from sdc_map.network import Network

    return Network("small", [lane for lane in town.driving if lane.id.startswith("quarter_ab")])


@pytest.mark.parametrize(
    ("kind", "x_m", "y_m", "held"),
    [
        ("ambulance", -15.0, 0.0, True),
        ("ambulance", -15.0, 1.5, True),
        ("ambulance", -15.0, 3.0, False),  # room to pass
        ("ambulance", -50.0, 0.0, False),  # still far
        ("ambulance", 15.0, 0.0, False),  # it has passed
        ("van", -15.0, 0.0, False),
    ],
)
def test_ambulance_is_held_up_by_a_car_close_ahead_on_its_way(kind, x_m, y_m, held):
    car = RoadUser(0, Rectangle(0.0, 0.0, 0.0, 4.7, 1.9), 8.0)
    other = RoadUser(7, Rectangle(x_m, y_m, 0.0, 5.9, 2.0), 12.0, kind)
    assert holds_up(car, [other]) == held
