"""Several cars in one world: what they see, how they meet, and no influence of their order."""

import math

import pytest
from presets import TESLA

from sdc_common.driving import Command
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.scenario.drive_setup import drive_setup
from sdc_sim.sensors.errors import OdometryNoise
from sdc_sim.simulation.shared_world import SharedWorld
from sdc_sim.simulation.simulation import OccupiedError, Simulation

STRAIGHT = [{"straight_m": 120}]


def world_of(end_m=None, **places):
    """Return a world of cars at poses (x, y, yaw)."""

    def car(name, pose):
        noise = OdometryNoise(len(name), position_m=0.1)
        return Simulation(Vehicle(TESLA), 0.05, 0.0, start=pose, noise=noise)

    return SharedWorld({name: car(name, pose) for name, pose in places.items()}, end_m)


def driven(world, commands, ticks):
    """Drive under one command for each car; return the snapshots of each car."""
    trace = {name: [car.snapshot] for name, car in world.cars.items()}
    for _ in range(ticks):
        world.step(commands)
        for name, car in world.cars.items():
            trace[name].append(car.snapshot)
    return trace


def collisions(snapshots):
    return [(one.stamp_ns, event.id) for one in snapshots for event in one.collisions]


def test_cars_see_each_other_where_they_are_with_speed_and_a_fixed_id():
    world = world_of(front=(20.0, 1.0, 0.3), back=(0.0, 0.0, 0.0))
    driven(world, {"front": Command(throttle=0.8), "back": Command()}, 40)
    front, state = world.cars["back"].snapshot.obstacles[0], world.cars["front"].vehicle.state
    assert (front.id, front.kind) == (1, "car")
    assert (front.x_m, front.y_m, front.yaw_rad) == (state.x_m, state.y_m, state.yaw_rad)
    assert front.speed_mps == state.speed_mps > 3.0
    (back,) = world.cars["front"].observation.obstacles
    assert (back.id, back.speed_mps) == (2, 0.0)


def test_cars_that_meet_collide_in_the_same_tick_and_keep_their_momentum():
    world = world_of(east=(0.0, 0.0, 0.0), west=(40.0, 0.5, math.pi))
    commands = {"east": Command(throttle=1.0), "west": Command(throttle=0.7)}
    trace = driven(world, commands, 80)
    (met,), (other,) = collisions(trace["east"]), collisions(trace["west"])
    assert met[0] == other[0] and (met[1], other[1]) == (2, 1)
    at = next(row for row, one in enumerate(trace["east"]) if one.collisions)
    east, west = trace["east"][at], trace["west"][at]
    assert west.state.x_m - east.state.x_m == pytest.approx(4.7, abs=0.01), "they touch"
    # They move on together; both have one mass, and the pushes are opposite.
    assert east.state.speed_mps == pytest.approx(-west.state.speed_mps, abs=0.01)
    before = trace["east"][at - 1].state.speed_mps, trace["west"][at - 1].state.speed_mps
    assert east.state.speed_mps == pytest.approx(0.5 * (before[0] - before[1]), abs=0.3)
    assert east.collisions[0].impulse_x_ns == -west.collisions[0].impulse_x_ns < -5000.0
    assert list(world.on_road) == [], "their drives have ended"


def test_fast_car_hits_a_car_from_behind_although_that_one_moves_on():
    world = world_of(behind=(0.0, 0.0, 0.0), ahead=(30.0, 0.0, 0.0))
    world.cars["behind"].set_velocity(15.0, 0.0, 0.0)
    world.cars["ahead"].set_velocity(10.0, 0.0, 0.0)
    trace = driven(world, {}, 150)
    assert collisions(trace["behind"]) and collisions(trace["ahead"])
    at = next(row for row, one in enumerate(trace["ahead"]) if one.collisions)
    assert trace["ahead"][at].state.speed_mps > trace["ahead"][at - 1].state.speed_mps + 1.0


def test_order_of_the_cars_changes_nothing_but_their_ids():
    # Two cars hit the one between them at the same time.
    places = {"a": (-15.0, 0.0, 0.0), "bb": (0.0, 0.0, 0.0), "ccc": (15.0, 0.0, math.pi)}
    places["dddd"] = (5.0, -9.0, 1.2)
    fast = Command(throttle=1.0)
    commands = {"a": fast, "ccc": fast, "dddd": Command(steer=1.0)}

    def outcome(names):
        world = world_of(**{name: places[name] for name in names})
        name_of = dict(enumerate(names, 1))

        def row(one):
            others = sorted((name_of[other.id], *other[1:]) for other in one.obstacles)
            events = [(name_of[event.id], *event[1:]) for event in one.collisions]
            return one.state, one.measured, others, events

        trace = driven(world, commands, 100)
        return {name: [*map(row, snapshots)] for name, snapshots in trace.items()}

    expected = outcome(["a", "bb", "ccc", "dddd"])
    assert sum(len(row[3]) for rows in expected.values() for row in rows) >= 2
    assert outcome(["a", "bb", "ccc", "dddd"]) == expected
    assert outcome(["dddd", "ccc", "bb", "a"]) == expected


def test_reset_repeats_the_drives_bit_for_bit():
    world = world_of(a=(0.0, 0.0, 0.0), b=(12.0, 0.0, 0.0))
    commands = {"a": Command(throttle=1.0), "b": Command(throttle=0.4)}

    def states():
        trace = driven(world, commands, 100)
        return [[one._replace(stamp_ns=0) for one in rows] for rows in trace.values()]

    first = states()
    assert any(one.collisions for one in first[0])
    world.reset()
    assert states() == first


def test_car_that_has_arrived_leaves_the_road_for_the_others():
    world = world_of((40.0, 0.0), a=(39.0, 0.0, 0.0), b=(20.0, 0.0, 0.0))
    assert len(world.cars["b"].snapshot.obstacles) == 1
    world.step()
    world.step()
    assert list(world.on_road) == ["b"] and world.cars["b"].snapshot.obstacles == ()
    assert not collisions(driven(world, {"b": Command(throttle=1.0)}, 100)["b"])
    assert world.cars["b"].vehicle.state.x_m > 45.0, "it drives through that place"


def test_cars_do_not_start_in_each_other():
    with pytest.raises(OccupiedError, match="a and b start at the same place"):
        world_of(a=(0.0, 0.0, 0.0), b=(3.0, 0.0, 0.0))


def test_cars_start_one_behind_the_other_or_side_by_side_with_noise_of_their_own():
    options = {"cars": 3, "odometry_noise": {"position_m": 0.1}}
    world = drive_setup("", STRAIGHT, options).world()
    assert list(world.cars) == ["ego_vehicle", "hero1", "hero2"]
    assert [round(car.vehicle.state.x_m, 6) for car in world.cars.values()] == [0.0, 12.0, 24.0]
    errors = {car.snapshot.measured.x_m - car.vehicle.state.x_m for car in world.cars.values()}
    assert len(errors) == 3
    beside = {"cars": 2, "next_car": {"along_m": 0.0, "left_m": 3.5}}
    states = [car.vehicle.state for car in drive_setup("", STRAIGHT, beside).world().cars.values()]
    assert [(one.x_m, round(one.y_m, 6)) for one in states] == [(0.0, 0.0), (0.0, 3.5)]


@pytest.mark.parametrize(
    ("scenario", "options", "message"),
    [
        ("", {"traffic": 3}, "traffic: not with cars:=2"),
        ("", {"truth": False}, "truth: not with cars:=2"),
        ("slow_leader", {}, "obstacles: not with cars:=2"),
        ("", {"next_car": {"along_m": 500.0}}, "start along_m must be from 0 to"),
        ("", {"cars": 9}, "cars must be a whole number from 1 to 8, got 9"),
    ],
)
def test_what_is_for_one_car_is_refused(scenario, options, message):
    route = None if scenario else STRAIGHT
    with pytest.raises(ValueError, match=message):
        drive_setup(scenario, route, {"cars": 2, **options}).world()
