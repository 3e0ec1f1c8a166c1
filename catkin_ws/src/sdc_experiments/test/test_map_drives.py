"""Drives on maps in one process: to the goal, the same twice, and on when the mission changes."""

import math
from itertools import islice
from types import SimpleNamespace

import numpy as np
import pytest

from sdc_common.geometry.route import Route
from sdc_experiments.closed_loop import car_with, drive_result, evaluation_rules
from sdc_experiments.configuration import node_parameters
from sdc_experiments.map_drives import had_emergency, main, seeds_of
from sdc_experiments.recorder import DriveRecorder
from sdc_map.global_planner import GlobalPlanner
from sdc_map.lane_graph import LaneGraph
from sdc_map.network_file import MapError, load_network
from sdc_package.car import MissionDriver
from sdc_package.local_planner import PlannerSettings
from sdc_sim.runner import isolated_drive, launch_arguments
from sdc_sim.scenario.drive_setup import drive_setup
from sdc_sim.scenario.map_drive import first_mission
from sdc_sim.simulation import loop
from sdc_testing.street_maps import has_libsumo, needs_maps, needs_traffic, town

pytestmark = [needs_maps, pytest.mark.slow(6)]

WEST, EAST, SOUTH = (-140.0, -5.0), (250.0, -2.0), (-2.0, -110.0)
TURN = "NonSignalizedJunctionRightTurn"
ON_TURN = {"map": "town", "sim_options": {"street_scenario": TURN}}


@pytest.fixture(scope="module", name="path")
def _path(tmp_path_factory):
    return town(tmp_path_factory.mktemp("town"))


def test_drive_to_a_goal_is_complete(path):
    first = drive_result(map=path, start=WEST, goal=[SOUTH])
    assert first.metrics["status"] == "completed"
    assert first.metrics["cross_track_rms_m"] < 0.05 and first.metrics["off_lane_percent"] == 0.0
    assert np.hypot(*(first.rows[-1, [1, 2]] - SOUTH)) < 5.0
    assert np.diff(first.rows[:60, 4]).max() < 0.05 * 1.9, "it starts gently"


@pytest.mark.parametrize(
    ("given", "same", "count"),
    [
        pytest.param({"goal": "-2,-110"}, {"goal": SOUTH}, 0, marks=pytest.mark.nightly),
        pytest.param(
            *({"goal": "-90,-5", "traffic": "12"}, {"goal": (-90.0, -5.0), "traffic": 12}, 12),
            marks=needs_traffic,
        ),
        ({"map": "town", "sim_options": f"{{street_scenario: {TURN}}}"}, ON_TURN, 13),
    ],
    ids=["alone", "in traffic", "scenario type"],
)
def test_drive_through_ros_has_the_same_trace(path, given, same, count):
    if "goal" in given:
        given, same = {"start": "-140,-5", **given}, {"start": WEST, **same}
    given = {"map": path, "seed": "4", **given}
    pages = {"camera": "false", "referee_options": "{pictures: true, snapshots: 0}"}
    with isolated_drive("", {**given, **pages}) as (drive, lines):
        assert lines == []
        assert "seed: 4" in drive.arguments["sim_options"]
        with open(drive.report_path.replace(".json", ".csv"), encoding="utf-8") as file:
            trace = [[float(one) for one in row.split(",")[:8]] for row in file.readlines()[1:]]
        with open(drive.report_path.replace(".json", ".html"), encoding="utf-8") as file:
            page = file.read()
    seen = []
    drive = drive_result(**{"map": path, **same}, seed=4, observe=lambda one: seen.append(one))
    assert np.array_equal(np.array(trace), drive.rows[:, :8])
    texts = {*drive.details} - {""}
    assert all(f'"{text}"' in page for text in texts) and (texts or given["map"] != "town")
    assert max(len(one.obstacles) for one in seen) == count


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"goal": "1,2,3"}, "goal:=1,2,3: must be X,Y"),
        ({"start": "a,b"}, "start:=a,b: must be X,Y"),
        ({"traffic": "many"}, "traffic:=many: must be a number of at least 0"),
        ({"seed": "-1"}, "seed:=-1: must be a number of at least 0"),
        ({"seed": "4", "sim_options": "{seed: 5}"}, "no other than the seed in sim_options"),
        ({"goal": "900,0"}, "is on no lane"),
    ],
)
def test_bad_argument_is_one_line(path, tmp_path, given, words):
    with pytest.raises(ValueError, match=words) as error:
        launch_arguments("", str(tmp_path / "report.json"), {"map": path, **given})
    assert "\n" not in str(error.value)


def test_random_town_is_that_of_the_seed(tmp_path):
    one, same = (drive_result(map=name, seed=5, longest_s=0.2) for name in ("random", "random:5"))
    assert np.array_equal(one.rows, same.rows, equal_nan=True)
    (tmp_path / "town.yaml").write_text("map: random\nseed: 5\n")
    rows = drive_result(str(tmp_path / "town.yaml"), longest_s=0.2).rows
    assert np.array_equal(one.rows, rows, equal_nan=True)
    arguments = launch_arguments("", str(tmp_path / "report.json"), {"map": "random", "seed": "5"})
    assert arguments["map"].endswith("random_5.net.xml")


def test_scenario_on_a_map(path, tmp_path):
    scenario = tmp_path / "to_the_south.yaml"
    scenario.write_text(f"map: {path}\ngoals: [[-2.0, -110.0]]\nseed: 7\n")
    rows = drive_result(str(scenario)).rows
    assert np.hypot(*(rows[-1, [1, 2]] - SOUTH)) < 5.0
    arguments = launch_arguments(str(scenario), str(tmp_path / "report.json"), {})
    assert (arguments["map"], arguments["goal"]) == (path, "[[-2.0, -110.0]]")
    start = np.loadtxt(arguments["waypoints_path"], delimiter=",")[0]
    assert start * (1.0, -1.0) == pytest.approx(rows[0, [1, 2]], abs=1e-6)
    scenario.write_text("goals: [[-2.0, -110.0]]\n")
    with pytest.raises(ValueError, match="map"):
        drive_result(str(scenario))


@pytest.mark.slow(12)
@pytest.mark.parametrize("conditions", [{}, {"traffic": 20}, {"street_scenario": "ParkingExit"}])
def test_drive_with_traffic_on_the_left_is_the_mirror_image_of_that_on_the_right(conditions):
    if "traffic" in conditions and not has_libsumo:
        pytest.skip("docker/prepare traffic has not been run")
    drives, counts = [], []
    for name in ("town", "town_left"):
        ticks = []
        options = {**conditions, "seed": 3}
        drive = drive_result(map=name, sim_options=options, longest_s=25.0, observe=ticks.append)
        states = (tick.state for tick in ticks)
        drives.append([(one.x_m, one.y_m, one.yaw_rad, one.speed_mps) for one in states])
        counts.append(drive.metrics["infractions"])
    right, left = map(np.array, drives)
    assert len(right) > 400 and np.ptp(right, axis=0)[:2].max() > 30.0
    assert left == pytest.approx(right * (1.0, -1.0, -1.0, 1.0), abs=1e-6)
    assert counts[0] == counts[1]


def test_cost_of_the_lab_chooses_on_the_streets():
    options = {"score_function": "sdc_behaviour.streets:score"}
    hazard = {"street_scenario": "HardBreakRoute"}
    driven = [
        drive_result(map="town", seed=1, sim_options=hazard, planner_options=chosen)
        for chosen in (options, {})
    ]
    assert [result.metrics["status"] for result in driven] == 2 * ["completed"]
    assert not np.array_equal(driven[0].rows, driven[1].rows)


def test_seed_without_a_map_is_that_of_the_noise():
    found = launch_arguments("", "", {"seed": "3", "sim_options": "{friction: 0.5}"})
    assert found == {"seed": "3", "sim_options": "{friction: 0.5, seed: 3}"}


@pytest.mark.parametrize(
    ("start", "goal", "options", "speed_mps"),
    [((-2.0, 110.0), SOUTH, {}, 8.0), (WEST, EAST, {}, 14.0)]
    + [(WEST, EAST, {"planned_speed_mps": 6.0}, 6.0)],
)
def test_limit_of_the_road_is_driven_and_the_planned_speed_caps_it(
    path, start, goal, options, speed_mps
):
    drive = drive_result(map=path, start=start, goal=goal, planner_options=options, longest_s=20.0)
    assert drive.metrics["speed_max_mps"] == pytest.approx(speed_mps, abs=0.3)
    assert drive.ideal.speed_mps.max() == pytest.approx(speed_mps)


def test_car_waits_at_the_lights_of_its_mission_and_at_no_others(path):
    seen, north = [], (118.4, 110.0)
    one = drive_result(map=path, start=north, goal=EAST, observe=seen.append).metrics
    assert one["status"] == "completed" and one["infractions"]["red_light"] == 0
    waits = [tick.state.y_m for tick in seen[100:-100] if tick.state.speed_mps < 0.01]
    assert len(waits) > 500 and min(waits) > 12.0 and max(waits) < 16.0  # its line is at 10.4 m
    other = drive_result(map=path, start=(118.4, 20.0), goal=(118.4, 14.0)).metrics
    assert other["status"] == "completed" and other["duration_s"] < 20.0


@pytest.mark.parametrize("change", ["goal", "closed lane"])
def test_new_mission_while_driving_needs_no_stop(path, change):
    missions = GlobalPlanner(load_network(path), [EAST])
    route = first_mission(missions.graph, WEST, [EAST], 0)[0].points_m
    world = drive_setup(route=route).simulation()
    settings = PlannerSettings.read(node_parameters("local_planner").__getitem__)
    car = car_with(MissionDriver(route, settings, missions=missions))
    rules = evaluation_rules(node_parameters("local_planner"), {"new_missions": True})
    recorder = DriveRecorder(rules, route, world)
    missions.on_mission = lambda new: recorder.evaluator.set_route(new.points_m)
    seen = []

    def observe(snapshot):
        seen.append(snapshot.state)
        if len(seen) == 160 and change == "goal":
            missions.drive_to([SOUTH])
        if len(seen) == 160 and change == "closed lane":
            missions.close(missions.mission.lanes[0])

    loop.drive(world, car, recorder, 30.0, observe)
    assert min(state.speed_mps for state in seen[150:400]) > 2.0
    assert missions.mission.lanes[-1].startswith("e_" if change == "goal" else "c_")
    if change == "goal":
        assert seen[-1].y_m < -20.0 and abs(seen[-1].x_m + 1.6) < 2.5
    found = recorder.evaluator.drive
    assert not found.over and math.dist(found.route.points[-1], missions.goals[0]) < 5.0


def test_command_drives_between_random_places(path, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["map_drives", path, "3"])
    main()
    assert "3 of 3 drives complete without infraction" in capsys.readouterr().out
    if has_libsumo:
        monkeypatch.setattr("sys.argv", ["map_drives", path, "2", "10"])
        main()
        printed = capsys.readouterr().out
        assert "2 completed" in printed and "drives without an emergency, " in printed
        assert "0 collisions, 0 at fault; seeds of those: none" in printed


@pytest.mark.nightly
def test_command_drives_in_a_set_of_towns(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["map_drives", "random:22-24", "2"])
    main()
    printed = capsys.readouterr().out
    assert "random_22: loaded" in printed and "2 of 2 drives complete without" in printed


def test_seeds_are_those_of_routes_about_as_long_as_wanted(path):
    graph = LaneGraph(load_network(path))
    seeds = list(islice(seeds_of(graph, 250), 3))
    assert seeds[2] > 2 and list(islice(seeds_of(graph, 0), 3)) == [0, 1, 2]
    assert list(islice(seeds_of(graph, 0, 7), 3)) == [7, 8, 9]
    assert len(list(islice(seeds_of(graph, 0), 3000))) == 3000
    with pytest.raises(MapError, match="routes is about 99999 m long; change LENGTH_M"):
        next(seeds_of(graph, 99_999))
    for seed in seeds:
        points_m = first_mission(graph, None, (), seed)[0].points_m
        assert np.hypot(*np.diff(points_m, axis=0).T).sum() == pytest.approx(250.0, rel=0.2)


@pytest.mark.parametrize(
    ("x_m", "from_m", "braking_mps2", "is_first", "expected"),
    [*((25.0, 3.0, 0.0, True, True), (40.0, 3.0, 0.0, True, False), (25.0, 1.0, 0.0, True, False))]
    + [(27.0, 3.0, 5.0, False, True), (27.0, 3.0, 5.0, True, False)],
    ids=["late", "early enough", "was there", "braked for it before", "gave way"],
)
def test_emergency_is_one_that_comes_late_into_the_way(
    x_m, from_m, braking_mps2, is_first, expected
):
    route = Route(np.column_stack([np.arange(101.0), np.zeros(101)]))
    size = {"yaw_rad": 0.0, "length_m": 4.7, "width_m": 1.9, "speed_mps": 0.0, "id": 7}
    snapshots, x, speed = [], 0.0, 10.0
    for tick in range(21):
        car = SimpleNamespace(x_m=x, y_m=0.0, speed_mps=speed)
        other = SimpleNamespace(x_m=x_m, y_m=from_m if tick < 20 else 1.0, **size)
        snapshots.append(SimpleNamespace(state=car, obstacles=[other]))
        x, speed = x + 0.05 * speed, speed - 0.05 * braking_mps2
    assert had_emergency(route, snapshots, lambda _: is_first) == expected
