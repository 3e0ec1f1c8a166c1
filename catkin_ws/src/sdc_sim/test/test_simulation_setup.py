"""Parameters of the sim node take effect; an invalid one is refused with one line that names it."""

import math
import os

import pytest
import rospy

from sdc_common.configuration import node_config
from sdc_common.driving import Command
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.ros import simulation_setup
from sdc_sim.ros.simulation_setup import SimulationSetup
from sdc_sim.scenario.packaged import folder_of
from sdc_sim.sensors.errors import OdometryNoise

TOWN = os.path.join(folder_of("route"), "waypoints.csv")
GIVEN = {"vehicles_folder": folder_of("vehicle"), "waypoints_path": TOWN, "obstacles_path": ""}
GIVEN.update(sync=False, camera=False, picture_feed="")


class Refused(Exception):
    pass


@pytest.fixture
def setup(monkeypatch):
    """Return a function that reads changed parameters; it raises Refused with the line."""

    def read(**changes):
        parameters = {**node_config("sdc_sim", "sim"), **GIVEN, **changes}
        known = {"~": parameters, **{f"~{name}": value for name, value in parameters.items()}}
        monkeypatch.setattr(rospy, "get_param", lambda name, *default: known[name])
        return SimulationSetup()

    def refuse(message):
        raise Refused(str(message))

    monkeypatch.setattr(simulation_setup, "refuse", refuse)
    return read


def test_noise_latencies_friction_wind_and_role_name_take_effect(setup):
    noise = {"position_m": 0.4, "heading_rad": 0.0, "speed_mps": 0.0}
    latencies = {"sensor_latency_s": 0.2, "command_latency_s": 0.25}
    options = {"friction": 0.3, "side_wind_mps": 15.0, "seed": 5, "role_name": "hero"}
    found = setup(odometry_noise=noise, **latencies, **options)
    assert found.ego == "/carla/hero"
    simulation, draws = found.simulation, OdometryNoise(5, 0.4)
    for _ in range(20):
        simulation.step()
    seen = simulation.snapshot
    assert seen.stamp_ns == (simulation.tick - 4) * 50_000_000
    for _ in range(seen.stamp_ns // 50_000_000):
        drawn = draws.apply(VehicleState())
    assert (seen.measured.x_m, seen.measured.y_m) == pytest.approx((drawn.x_m, drawn.y_m))

    while simulation.vehicle.state.speed_mps < 8.0:
        simulation.step(Command(throttle=0.8))
        assert simulation.tick < 400
    assert abs(simulation.vehicle.state.yaw_rad) > 1e-3, "only the wind turns the car"
    brakes, speeds_mps = [], []
    for _ in range(30):
        simulation.step(Command(brake=1.0))
        brakes.append(simulation.commands.executed.brake)
        speeds_mps.append(simulation.vehicle.state.speed_mps)
    assert brakes[:6] == [0.0] * 5 + [1.0]
    assert 1.0 < speeds_mps[9] - speeds_mps[-1] < 0.3 * 1.05 * 9.81 * 1.1


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"frictoin": 0.5}, ["frictoin", "did you mean 'friction'"]),
        ({"friction": 0.0}, ["friction must be a number from 0.001 to 100", "config/sim.yaml"]),
        ({"tick_s": math.nan}, ["tick_s must be a number from 0.001 to 1"]),
        ({"odometry_noise": {"position_m": -1.0}}, ["odometry_noise: 'position_m' must be"]),
        ({"start": {"left_m": math.inf}}, ["start: 'left_m' must be"]),
        ({"ackermann": {"kp_per_s": 0.0}}, ["ackermann: 'kp_per_s' must be a positive number"]),
        ({"weather": {"rain": 2.0}}, ["rain", "config/sim.yaml"]),
        ({"start": {"along_m": 1e6, "left_m": 0.0, "turned_rad": 0.0}}, ["along_m"]),
        ({"bridge": "newer"}, ["bridge is 'newer'; did you mean 'new'?", "config/sim.yaml"]),
        ({"ackermann": {"kp": 1.0}}, ["kp", "config/sim.yaml"]),
        ({"ackermann_cmd": "yes"}, ["ackermann_cmd is 'yes'", "auto, true, false"]),
        ({"drive_log": "/nowhere/log"}, ["drive_log: /nowhere/log: No such file"]),
    ],
)
def test_invalid_parameter_is_named(setup, changes, parts):
    with pytest.raises(Refused) as refusal:
        setup(**changes)
    assert [part for part in parts if part not in str(refusal.value)] == []
    assert "\n" not in str(refusal.value)


OBSTACLES = "frame: route\nobstacles:\n  - {kind: %s, at: [1.0, 0.0]}\n"


@pytest.mark.parametrize(
    ("parameter", "text", "parts"),
    [
        ("obstacles_path", OBSTACLES % "pedestrain", ["line 3", "did you mean 'pedestrian'"]),
        ("obstacles_path", OBSTACLES % "car", ["the car at (1.0, 0.0)"]),
        ("waypoints_path", "1,2\n", ["file.yaml", "at least 2"]),
        ("vehicles_folder", "mass_kg: -5.0\n", ["file.yaml", "mass_kg"]),
    ],
)
def test_invalid_file_is_named(setup, tmp_path, parameter, text, parts):
    (tmp_path / "file.yaml").write_text(text)
    changes = {parameter: str(tmp_path / "file.yaml")}
    if parameter == "vehicles_folder":
        changes = {parameter: str(tmp_path), "vehicle": "file"}
    with pytest.raises(Refused) as refusal:
        setup(**changes)
    assert [part for part in parts if part not in str(refusal.value)] == []
