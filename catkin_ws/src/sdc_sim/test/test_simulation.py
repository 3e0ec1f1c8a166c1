"""The simulation: ticks, commands, collisions, placing, latencies; without ROS."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from presets import TESLA

from sdc_common.configuration import node_config
from sdc_common.driving import Command
from sdc_sim.physics.ackermann import AckermannTarget
from sdc_sim.physics.collision import overlap
from sdc_sim.physics.obstacles import KINDS, ObstaclePlan, Obstacles, ObstacleState
from sdc_sim.physics.traffic_lights import GREEN, RED, TrafficLightPlan
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.sensors.errors import OdometryNoise
from sdc_sim.simulation.simulation import OccupiedError, Simulation


def make_simulation(timeout_s=1.0, **options):
    return Simulation(Vehicle(TESLA), 0.05, timeout_s, **options)


def obstacle_at(x_m, y_m=0.0, yaw_rad=0.0, kind="obstacle"):
    return Obstacles([ObstaclePlan.stationary(kind, x_m, y_m, yaw_rad)])


def stepped(simulation, command=None):
    simulation.step(command)
    return simulation.snapshot


def drive(simulation, seconds, **command):
    """Drive under one command; return the collisions that began."""
    collisions = []
    for _ in range(round(seconds / simulation.tick_s)):
        collisions += stepped(simulation, Command(**command)).collisions
    return collisions


class Approaching:
    """A car of the traffic that drives towards the origin, and a pedestrian beside the road."""

    def reset(self, ego):
        self.x_m, self.blocked = -20.0, []
        return self.states()

    def advance(self, ego, speed_mps, braking, blocked):
        self.blocked.append(set(blocked))
        self.x_m += 0.0 if blocked else 0.5
        return self.states()

    def states(self):
        walker = ObstacleState(10002, "pedestrian", 0.0, 9.0, 0.0, *KINDS["pedestrian"].size_m, 1.0)
        car = ObstacleState(10001, "car", self.x_m, 0.0, 0.0, *KINDS["car"].size_m, 10.0)
        return [car, walker]


def test_road_user_that_hits_the_vehicle_stops_there_and_is_one_collision():
    traffic = Approaching()
    simulation = make_simulation(traffic=traffic)
    collisions = drive(simulation, 3.0, brake=1.0)
    assert [one.id for one in collisions] == [10001]
    # It pushes the vehicle forward with its momentum.
    assert collisions[0].impulse_x_ns == pytest.approx(18_000.0)
    car = simulation.snapshot.obstacles[0]
    assert not overlap(car.rectangle, simulation.outline) and car.speed_mps == 0.0
    assert simulation.outline.x_m - car.x_m < 4.7 + 0.5
    assert traffic.blocked[-1] == {10001} and traffic.blocked[0] == set()
    assert len(simulation.observation.obstacles) == 2
    with pytest.raises(OccupiedError, match="the pedestrian at"):
        simulation.place(0.0, 9.0, 0.0)
    simulation.reset()
    assert simulation.snapshot.obstacles[0].x_m == -20.0


def test_default_timeout_allows_for_a_lost_command_at_10_hz_and_ends_within_half_a_second():
    simulation = make_simulation(node_config("sdc_sim", "sim")["command_patience_s"])
    command = Command(throttle=0.5)
    simulation.step(command)
    executed = []
    for _ in range(10):
        simulation.step()
        executed.append(simulation.commands.executed)
    # The next command comes after 0.2 s, and may be a tick late.
    assert executed[:4] == 4 * [command]
    assert executed[-1] == Command(brake=1.0)


def test_vehicle_stops_at_an_obstacle_with_one_collision_and_its_momentum():
    simulation = make_simulation(obstacles=obstacle_at(30.0))
    speeds = []
    collisions = []
    for _ in range(200):
        speeds.append(simulation.vehicle.state.speed_mps)
        collisions += drive(simulation, 0.05, throttle=0.6)
    (collision,) = collisions
    assert collision.id == simulation.obstacles.states[0].id
    assert collision.impulse_x_ns == pytest.approx(-1845.0 * max(speeds), rel=0.05)
    assert collision.impulse_y_ns == pytest.approx(0.0, abs=1.0)
    assert simulation.vehicle.state.speed_mps == pytest.approx(0.0, abs=0.2)
    assert simulation.vehicle.state.x_m == pytest.approx(30.0 - 0.5 - 2.35, abs=0.01)


def test_obstacle_without_contact_does_not_change_a_bit_of_the_drive():
    alone, passing = make_simulation(), make_simulation(obstacles=obstacle_at(30.0, 2.6))
    for simulation in (alone, passing):
        assert drive(simulation, 8.0, throttle=0.6) == []
    assert alone.vehicle.state == passing.vehicle.state


@pytest.mark.slow(3)
@settings(max_examples=60, deadline=None)
@given(
    *map(st.floats, (0.0, -math.pi, -1.0, -1.4, 0.0), (40.0, math.pi, 1.0, 1.4, math.pi)),
    st.sampled_from(sorted(KINDS)),
)
def test_no_drive_enters_an_obstacle_or_gains_speed_from_it(
    speed_mps, heading, steer, aside_m, yaw, kind
):
    simulation = make_simulation(timeout_s=0.0)
    simulation.vehicle.reset(0.0, 0.0, heading, speed_mps)
    c, s = math.cos(heading), math.sin(heading)
    simulation.obstacles = obstacle_at(12.0 * c - aside_m * s, 12.0 * s + aside_m * c, yaw, kind)
    obstacle = simulation.obstacles.states[0]
    assert overlap(simulation.outline, obstacle.rectangle) is None
    simulation.accept(Command(steer=steer))
    for _ in range(60):
        state = simulation.vehicle.state
        before = math.hypot(state.speed_mps, state.lateral_speed_mps)
        collisions = stepped(simulation).collisions
        assert overlap(simulation.outline, obstacle.rectangle) is None
        state = simulation.vehicle.state
        if collisions:
            assert math.hypot(state.speed_mps, state.lateral_speed_mps) <= before + 0.1
            impulse_ns = math.hypot(collisions[0].impulse_x_ns, collisions[0].impulse_y_ns)
            assert impulse_ns <= 1845.0 * (before + 0.1)


def test_place_forgets_the_command():
    simulation = make_simulation()
    drive(simulation, 3.0, throttle=0.8)
    simulation.place(50.0, 60.0, 1.0)
    simulation.step()
    state = simulation.vehicle.state
    assert (state.x_m, state.y_m, state.speed_mps) == (50.0, 60.0, 0.0)


def test_disturbances_change_from_a_tick_on():
    noise = {"position_m": 0.1, "heading_rad": 0.0, "speed_mps": 0.0}
    simulation = make_simulation(noise=OdometryNoise(7))
    drive(simulation, 1.0, throttle=0.7)
    assert simulation.snapshot.measured == simulation.snapshot.state
    simulation.set_disturbances(0.2, 15.0, noise)
    speed_mps = simulation.vehicle.state.speed_mps
    drive(simulation, 0.5, brake=1.0)
    state = simulation.snapshot.state
    assert simulation.snapshot.measured.x_m != state.x_m
    # The grip limits the deceleration to a fifth of gravity; the wind pushes the car to the left.
    assert speed_mps - state.speed_mps < 0.5 * 0.2 * 9.81 * 1.1
    assert state.y_m > 0.0


def test_observe_again_shows_what_was_placed_and_added():
    simulation = make_simulation(sensor_latency_s=0.15)
    stamp = simulation.snapshot.stamp_ns
    simulation.place(40.0, 2.0, 0.1)
    simulation.obstacles.toggle(ObstaclePlan.stationary("car", 70.0, 0.0, 0.0), simulation.outline)
    observation = simulation.observe_again()
    assert (observation.stamp_ns, observation.state.x_m) == (stamp, 40.0)
    assert observation.measured.y_m == 2.0
    assert [obstacle.x_m for obstacle in observation.obstacles] == [70.0]


def rich_simulation():
    """Return a simulation with every kind of state."""
    across, around = ((15.0, -3.0), (15.0, 3.0)), ((40.0, 0.0), (60.0, 0.0), (60.0, 20.0))
    plans = [
        ObstaclePlan("pedestrian", across, (0.5, 0.5, 1.75), speed_mps=1.4, trigger_m=12.0),
        ObstaclePlan("car", around, (4.7, 2.0, 1.45), speed_mps=3.0, start_s=0.5),
        ObstaclePlan.stationary("obstacle", 10.0, 5.0, 0.3),
    ]
    lights = [TrafficLightPlan(50.0, 0.0, 0.0, (("red", 2.0), ("green", 1.0)))]
    latencies = {"command_latency_s": 0.1, "sensor_latency_s": 0.15}
    around = {"obstacles": Obstacles(plans), "lights": lights}
    return make_simulation(0.4, noise=OdometryNoise(3, 0.05, 0.01, 0.1), **around, **latencies)


COMMANDS = [
    *[Command(throttle=0.7, steer=0.02 * n) for n in range(10)] * 5,
    *[AckermannTarget(0.1, 0.0, 6.0), None, None] * 20,
    *[None] * 15,
    *[Command(brake=0.5)] * 10,
]


def trace(simulation):
    """Return all observations of a drive with the same commands."""
    return [simulation.snapshot, *(stepped(simulation, command) for command in COMMANDS)]


def test_reset_repeats_the_trace_bit_for_bit_with_later_stamps():
    simulation = rich_simulation()
    first = trace(simulation)
    simulation.obstacles.toggle(ObstaclePlan.stationary("car", -20.0, 0.0, 0.1), simulation.outline)
    last_stamp = simulation.snapshot.stamp_ns
    simulation.reset()
    assert simulation.snapshot.stamp_ns == last_stamp
    second = trace(simulation)

    def without_stamps(observations):
        return [repr(observation[1:]) for observation in observations]

    assert without_stamps(second) == without_stamps(first)
    lights = [observation.traffic_lights[0].state for observation in first]
    assert lights[:70] == [RED] * 40 + [GREEN] * 20 + [RED] * 10
