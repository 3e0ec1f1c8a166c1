"""Other road users that SUMO moves, and the traffic lights of a map."""

import importlib
import math
import sys
from pathlib import Path

import numpy as np
import pytest

from sdc_common.validation import DocumentError
from sdc_map.map_file import map_file
from sdc_map.network import WALKING, edge_of
from sdc_map.network_file import load_network
from sdc_sim.physics.collision import Rectangle, overlap
from sdc_sim.physics.traffic_lights import COLOURS
from sdc_sim.scenario.drive_setup import drive_setup
from sdc_sim.traffic import lights
from sdc_testing.street_maps import has_libsumo, needs_traffic, town

if has_libsumo:
    from sdc_sim.traffic.sumo_traffic import SumoTraffic
pytestmark = [needs_traffic, pytest.mark.slow(8)]

TICK_S, FREE = 0.05, frozenset()
COLOUR_OF = {"G": "green", "g": "green", "y": "yellow", "r": "red"}


@pytest.fixture(scope="module", name="path")
def _path(tmp_path_factory):
    return town(tmp_path_factory.mktemp("town"))


@pytest.fixture(scope="module", name="network")
def _network(path):
    return load_network(path)


def car_on(network, lane, s_m):
    """Return a car on a lane, by its centre."""
    (x_m, y_m), lane = network.lanes[lane].at(np.array([s_m]))[0].tolist(), network.lanes[lane]
    return Rectangle(x_m, y_m, lane.heading_at(s_m), 4.7, 2.0)


def start(path, network, count=20, seed=1, mission=("a_0", "b_0")):
    net_path, edges = load_network(path).net_path, map(edge_of, mission)
    return SumoTraffic(net_path, count, seed, TICK_S, edges, network.y_sign < 0.0)


def standing(traffic, ego, ticks):
    """Return the road users in each tick, with our car standing."""
    return [traffic.reset(ego), *(traffic.advance(ego, 0.0, True, FREE) for _ in range(ticks))]


def test_same_seed_gives_the_same_traffic_and_another_one_does_not(path, network):
    ego = car_on(network, "a_0", 60.0)
    first = start(path, network)
    runs = [standing(first, ego, 200), standing(first, ego, 200)]
    runs += [standing(start(path, network, seed=seed), ego, 200) for seed in (1, 2)]
    assert runs[0] == runs[1] == runs[2] != runs[3]


def test_number_of_road_users_is_kept_and_those_that_arrive_are_replaced(path, network):
    ticks = standing(start(path, network), car_on(network, "a_0", 60.0), 1200)
    assert len(ticks[0]) >= 12 and np.mean([len(one) for one in ticks[100:]]) > 18.0
    assert max(len(one) for one in ticks) == 20
    assert len({one.id for tick in ticks for one in tick}) > 25
    assert len({one.kind for tick in ticks for one in tick}) >= 4


@pytest.mark.parametrize("speed_mps", [0.0, 36.0])
def test_none_begins_where_it_or_our_car_could_not_brake_gently_before_the_other(speed_mps):
    network, way = load_network("town"), ("land_e_0", "land_n_0")
    ego, seen = car_on(network, way[0], network.lanes[way[0]].length_m - 5.0), set()
    traffic = start(map_file("town"), network, 40, mission=way)
    seen = {one.id for one in traffic.reset(ego)}
    for _ in range(1200):
        tick = traffic.advance(ego, speed_mps, speed_mps == 0.0, FREE)
        for one in tick:
            distance_m = math.hypot(one.x_m - ego.x_m, one.y_m - ego.y_m)
            assert one.id in seen or distance_m > 40.0 + max(one.speed_mps, speed_mps) ** 2 / 6.0
        seen = {one.id for one in tick}


@pytest.mark.parametrize("more", [(), ("--lefthand",)])
def test_road_users_are_on_lanes_of_their_kind_and_direction(tmp_path, more):
    path = town(tmp_path, more=more)
    network = load_network(path)
    walks = [lane.points_m for lane in network.lanes.values() if lane.kind == WALKING]
    walks += list(network.crosswalks)
    for tick in standing(start(path, network, 40, 3), car_on(network, "a_0", 60.0), 600)[::40]:
        for one in tick:
            if one.kind == "pedestrian":
                distance_m = min(np.hypot(*(line - (one.x_m, one.y_m)).T).min() for line in walks)
                assert distance_m < 61.0  # lines have points at their ends
                continue
            place = network.nearest(one.x_m, one.y_m, one.yaw_rad)
            assert abs(place.cross_track_m) < 1.5 and abs(place.heading_error_rad) < 1.0, one


def test_others_turn_round_at_dead_ends_alone(tmp_path):
    import libsumo

    path = town(tmp_path, turns="--no-internal-links=false")
    start(path, load_network(path), 40).reset(Rectangle(-60.0, -2.0, 0.0, 4.7, 2.0))
    routes = map(libsumo.vehicle.getRoute, libsumo.vehicle.getIDList())
    pairs = {pair for route in routes for pair in zip(route, route[1:])}
    turned = {one for one, other in pairs if one.strip("-") == other.strip("-")}
    assert turned and turned <= {"-a", "c", "-d", "e", "f"}


def test_those_behind_our_standing_car_stop_and_do_not_hit_it(path, network):
    import libsumo

    ego, traffic = car_on(network, "d_0", 80.0), start(path, network, 0, mission=("d_0", "e_0"))
    kinds = ["car.calm", "lorry", "bicycle", "car.aggressive"]
    traffic.reset(ego)
    libsumo.route.add("from the north", ["d", "e"])
    for number, kind in enumerate(kinds):
        libsumo.vehicle.add(kind, "from the north", kind, depart=str(3 * number))
    for _ in range(1200):
        traffic.advance(ego, 0.0, True, FREE)
        fronts = [libsumo.vehicle.getPosition(kind)[1] for kind in kinds]
        assert min(front for front in fronts if front > -1e6) > ego.y_m + 0.5 * ego.length_m
    assert sorted(fronts) == fronts and max(map(libsumo.vehicle.getSpeed, kinds)) < 0.1
    assert fronts[0] < ego.y_m + 8.0


def test_one_that_our_car_has_passed_is_before_those_behind_it(path, network):
    import libsumo

    traffic, vehicle = start(path, network, 0, mission=("d_0", "e_0")), libsumo.vehicle
    traffic.reset(car_on(network, "d_0", 10.0))
    libsumo.route.add("from the north", ["d", "e"])
    vehicle.add("slow", "from the north", "bicycle", departPos="25", departSpeed="4")
    for tick in range(160):
        s_m = min(10.0 + 0.5 * tick, network.lanes["d_0"].length_m - 5.0)
        traffic.advance(car_on(network, "d_0", s_m), 10.0, False, FREE)
        if tick == 60:
            vehicle.add("fast", "from the north", "car.calm", departPos="0", departSpeed="10")
        if tick > 80 and {vehicle.getLaneID(one) for one in ("slow", "fast")} == {"d_0"}:
            assert vehicle.getLanePosition("fast") < vehicle.getLanePosition("slow")
    assert vehicle.getSpeed("fast") < 6.0


@pytest.mark.parametrize("mission", [("a_0", "b_0"), ("e_0",)], ids=["on its mission", "elsewhere"])
def test_others_give_way_to_our_car_on_the_main_road(path, network, mission):
    import libsumo

    traffic, lane = start(path, network, 0, mission=mission), network.lanes["a_0"]
    lows = []
    for is_near in (True, False):
        s_m = lane.length_m - (100.0 if is_near else 140.0)
        traffic.reset(car_on(network, "a_0", s_m))
        libsumo.route.add("from the north", ["d", "e"])
        place = {"typeID": "car.calm", "departPos": "40", "departSpeed": "8"}
        libsumo.vehicle.add("other", "from the north", **place)
        speeds = []
        for tick in range(240):
            ego = car_on(network, "a_0", s_m + 0.5 * tick * is_near)
            traffic.advance(ego, 10.0 * is_near, False, FREE)
            if "other" in libsumo.vehicle.getIDList():
                speeds.append(libsumo.vehicle.getSpeed("other"))
        lows.append(min(speeds))
    assert lows[0] < 1.5 and lows[1] > 4.0


def test_one_that_is_held_stops_and_drives_on(path, network):
    traffic, ego = start(path, network), car_on(network, "a_0", 60.0)
    fastest = max(traffic.reset(ego), key=lambda one: one.speed_mps)

    def after(ticks, held):
        for _ in range(ticks):
            states = traffic.advance(ego, 0.0, True, held)
        return next(one.speed_mps for one in states if one.id == fastest.id)

    assert after(120, frozenset({fastest.id})) < 0.1
    assert after(60, FREE) > 1.0


def test_one_that_waits_for_another_lane_drives_where_its_own_leads(path, network):
    import libsumo

    traffic, ego, vehicle = start(path, network), car_on(network, "-a_1", 60.0), libsumo.vehicle
    traffic.reset(ego)
    name = None
    while name is None:
        traffic.advance(ego, 0.0, True, FREE)
        names = libsumo.lane.getLastStepVehicleIDs("b_1")
        name = next((name for name in names if "c" in vehicle.getRoute(name)), None)
    vehicle.setLaneChangeMode(name, 0)
    vehicle.setRoute(name, ["b", "f"])
    for _ in range(2400):
        traffic.advance(ego, 0.0, True, FREE)
    assert name not in libsumo.lane.getLastStepVehicleIDs("b_1")


def test_pedestrian_who_would_walk_into_our_standing_car_leaves_the_road(path, network):
    traffic, far = start(path, network), car_on(network, "a_0", 60.0)
    users = standing(traffic, far, 100)[-1]
    walker = next(one for one in users if one.kind == "pedestrian" and one.speed_mps > 0.5)
    ahead_x, ahead_y = 4.0 * math.cos(walker.yaw_rad), 4.0 * math.sin(walker.yaw_rad)
    ego = Rectangle(walker.x_m + ahead_x, walker.y_m + ahead_y, walker.yaw_rad, 4.7, 2.0)
    for _ in range(100):
        users = traffic.advance(ego, 0.0, True, FREE)
        assert not any(overlap(one.rectangle, ego) for one in users)


@pytest.mark.parametrize("kind", ["static", "actuated"])
def test_lights_have_the_colours_of_sumo_at_each_tick(path, tmp_path, kind):
    old, new = (f'type="{one}" programID="0" offset="{s}"' for one, s in (("static", 0), (kind, 7)))
    shifted = tmp_path / "shifted.net.xml"
    shifted.write_text(Path(path).read_text("utf-8").replace(old, new), encoding="utf-8")
    network, plans = load_network(str(shifted)), lights.of_map(str(shifted))
    junction = network.junctions["light"]
    traffic, ego = start(str(shifted), network, 0), car_on(network, "a_0", 60.0)
    traffic.reset(ego)
    libsumo = importlib.import_module("libsumo")  # the simulation of this process
    seen = set()
    for tick in range(2000):
        letters = libsumo.trafficlight.getRedYellowGreenState("light")
        seen.add(letters)
        for plan in plans if tick % 7 == 0 else ():
            place, ways = (plan.x_m, plan.y_m), junction.connections
            ends = ((one, network.lanes[one.start].points_m[-1]) for one in ways)
            signals = {one.signal for one, end in ends if math.dist(end, place) < 0.01}
            colours = {COLOUR_OF[letters[one]] for one in signals}
            assert COLOURS[plan.state(tick * TICK_S)] in colours, (tick, plan)
        traffic.advance(ego, 0.0, True, FREE)
    assert len(seen) >= 4


def test_light_is_at_the_end_of_each_lane_and_its_pole_beside_the_road(path, network):
    plans = lights.of_map(path)
    starts = {one.start for one in network.junctions["light"].connections if one.signal >= 0}
    ends = {tuple(network.lanes[name].points_m[-1]) for name in starts}
    assert {(plan.x_m, plan.y_m) for plan in plans} == ends and len(plans) == len(starts)
    for plan in plans:
        assert {"red", "green"} <= {colour for colour, _ in plan.phases}
        place = network.nearest(*plan.pole_m)
        assert abs(place.cross_track_m) > 0.5 * network.lanes[place.lane].width_m


def test_world_sees_road_users_and_lights_of_its_map(path):
    options = {"map_path": path, "traffic": 15, "seed": 3, "start": {"along_m": 30.0}}
    route = load_network(path).lanes["a_0"].points_m
    world = drive_setup(route=route, options=options).simulation()
    assert len(world.observation.obstacles) >= 8 and len(world.observation.light_states) == 4
    before = world.snapshot.obstacles
    world.step()
    assert world.snapshot.obstacles != before
    for _ in range(100):
        world.step()
    world.reset()
    assert world.snapshot.obstacles == before
    alone = drive_setup(route=route, options={**options, "traffic": 0}).simulation()
    assert not alone.observation.obstacles
    assert alone.observation.light_states == world.observation.light_states


def test_second_world_in_traffic_ends_the_first_with_one_clear_error(path, network):
    ego = car_on(network, "a_0", 60.0)
    first, second = start(path, network), start(path, network)
    second.reset(ego)
    with pytest.raises(RuntimeError, match="another world in traffic was started"):
        first.advance(ego, 0.0, True, FREE)


def test_traffic_without_a_map_or_without_libsumo_is_one_line(path, monkeypatch):
    with pytest.raises(DocumentError, match=r"traffic: .* name a map \(map:=FILE\)"):
        drive_setup(options={"traffic": 5}).simulation()
    monkeypatch.setitem(sys.modules, "libsumo", None)
    with pytest.raises(DocumentError, match="run docker/prepare traffic") as error:
        drive_setup(options={"traffic": 5, "map_path": path}).simulation()
    assert "\n" not in str(error.value)


def test_rails_without_phases_and_projections_without_data_are_no_problem(tmp_path, capfd):
    net = Path(town(tmp_path, mid="rail_signal"))
    net.write_text(net.read_text().replace('projParameter="!"', 'projParameter="+proj=utm"'))
    network = load_network(str(net))
    traffic = start(str(net), network)
    assert len(standing(traffic, car_on(network, "a_0", 60.0), 20)[-1]) > 5
    assert "proj.db" not in capfd.readouterr().err


def test_file_that_is_no_network_is_one_line(tmp_path):
    path = tmp_path / "broken.net.xml"
    path.write_text("<net", encoding="utf-8")
    with pytest.raises(DocumentError, match="SUMO refuses the network"):
        SumoTraffic(str(path), 1, 0, TICK_S, ())
