"""The fastest way over lanes: costs are those of Dijkstra's algorithm of networkx."""

import networkx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_map.lane_graph import CHANGE_M, CHANGE_S, LaneGraph, NoRouteError, drawn_places
from sdc_map.mission import plan_mission
from sdc_map.network import LanePlace, Network, RoadLane

_COUNT = st.integers(2, 14)
_NUMBER = st.integers(0, 13)


def network_of(lengths, edges, sides=(), speed_mps=5.0, faster=1):
    """Return lanes with names 0, 1, ...; `sides` are pairs (right, left)."""
    lanes = []
    for i, length in enumerate(lengths):
        leads = tuple(dict.fromkeys(str(b) for a, b in edges if a == i))
        left = next((str(b) for a, b in sides if a == i), "")
        right = next((str(a) for a, b in sides if b == i), "")
        line = np.array([[0.0, 9.0 * i], [length, 9.0 * i]])
        lanes.append(
            RoadLane(
                str(i), line, 3.5, speed_mps + i % faster, successors=leads, left=left, right=right
            )
        )
    return Network("test", lanes)


def place(lane, s_m=0.0):
    return LanePlace(str(lane), s_m, 0.0, 0.0)


@st.composite
def networks(draw):
    count = draw(_COUNT)
    number = st.integers(0, count - 1)
    lengths = draw(st.lists(st.floats(1.0, 300.0), min_size=count, max_size=count))
    edges = draw(st.lists(st.tuples(number, number), max_size=3 * count))
    firsts = draw(st.lists(st.sampled_from(range(0, count - 1, 2)), unique=True, max_size=4))
    return network_of(lengths, edges, [(i, i + 1) for i in firsts], speed_mps=4.0, faster=3)


@pytest.mark.slow(2)
@given(networks(), _NUMBER, _NUMBER, st.sets(_NUMBER, max_size=2))
def test_cost_is_that_of_networkx(network, start, goal, closed):
    start, goal = start % len(network.lanes), goal % len(network.lanes)
    lanes = [network.lanes[str(i)] for i in range(len(network.lanes))]
    graph = networkx.DiGraph()
    graph.add_nodes_from(network.lanes)
    for lane in lanes:
        pairs = [(name, lane.length_m / lane.speed_limit_mps) for name in lane.successors]
        if lane.length_m >= CHANGE_M:
            pairs += [(name, CHANGE_S) for name in (lane.left, lane.right) if name]
        for name, cost in pairs:
            if (
                int(name) not in closed
                and cost < graph.get_edge_data(lane.id, name, {"weight": 1e9})["weight"]
            ):
                graph.add_edge(lane.id, name, weight=cost)
    first, last = lanes[start], lanes[goal]
    # Where the places are on neighbours or too close to the end, see the tests below.
    if last.id in (first.left, first.right) or (first.length_m < CHANGE_M and start != goal):
        return
    try:
        expected = networkx.dijkstra_path_length(graph, first.id, last.id)
    except networkx.NetworkXNoPath:
        expected = None
    try:
        way, cost = LaneGraph(network).route(place(start), place(goal), set(map(str, closed)))
    except NoRouteError:
        assert expected is None
        return
    assert cost == pytest.approx(expected)
    assert way[0] == first.id and way[-1] == last.id
    total = sum(graph.edges[a, b]["weight"] for a, b in zip(way, way[1:]))
    assert total == pytest.approx(expected)


# 0 and 1 are beside one another; both lead to 2, which leads back to 0.
_LOOP = network_of([200.0, 200.0, 100.0], [(0, 2), (1, 2), (2, 0)], [(0, 1)])


@pytest.mark.parametrize(
    ("start", "goal", "way"),
    [
        (place(0, 10.0), place(0, 150.0), ["0"]),
        (place(0, 150.0), place(0, 10.0), ["0", "2", "0"]),
        (place(0, 10.0), place(1, 150.0), ["0", "1"]),
        (place(0, 150.0), place(1, 50.0), ["0", "2", "0", "1"]),
        (place(0, 100.0), place(1, 100.0 + 0.5 * CHANGE_M), ["0", "2", "0", "1"]),
        (place(0, 195.0), place(1, 198.0), ["0", "2", "0", "1"]),
    ],
)
def test_goal_behind_or_beside_needs_a_loop(start, goal, way):
    assert LaneGraph(_LOOP).route(start, goal)[0] == way


def test_cost_counts_from_the_start_to_the_goal():
    _, cost = LaneGraph(_LOOP).route(place(0, 50.0), place(2, 30.0))
    assert cost == pytest.approx(150.0 / 5.0 + 30.0 / 5.0)


@pytest.mark.parametrize(
    ("lengths", "goal_m", "way"),
    [((30.0, 200.0), 150.0, "023"), ((200.0, 30.0), 20.0, "013"), ((200.0, 300.0), 30.0, "013")],
    ids=["short stretch first", "short stretch last", "goal near the begin of the last"],
)
def test_lanes_are_changed_where_there_is_room(lengths, goal_m, way):
    both = [one for one in lengths for _ in range(2)]
    network = network_of(both, [(0, 2), (1, 3)], [(0, 1), (2, 3)], speed_mps=20.0)
    assert LaneGraph(network).route(place(0), place(3, goal_m))[0] == list(way)


def test_lanes_are_changed_early():
    mission = plan_mission(
        LaneGraph(network_of((300.0, 300.0), [], [(0, 1)])), [(290.0, 9.0)], 10.0, 0.0, 0.0
    )
    beside = mission.points_m[:, 1] > 0.1
    assert 30.0 < mission.points_m[beside, 0].min() < 60.0


def test_mission_ends_beside_a_goal_whose_lane_it_has_no_room_to_reach():
    edges, sides = [(0, 2), (1, 3)], [(2, 3)]
    graph = LaneGraph(network_of((100.0, 100.0, 200.0, 200.0), edges, sides))
    for along_m, way in ((CHANGE_M - 1.0, ("0", "2")), (CHANGE_M + 1.0, ("0", "2", "3"))):
        goal = graph.network.lanes["3"].at(np.array([along_m]))[0]
        mission = plan_mission(graph, [goal], 10.0, 0.0, 0.0)
        assert mission.lanes == way and mission.points_m[-1, 0] == pytest.approx(along_m)


def test_closed_lane_is_avoided_and_unreachable_lane_is_named():
    network = network_of([50.0, 10.0, 90.0, 50.0], [(0, 1), (0, 2), (1, 3), (2, 3)])
    graph = LaneGraph(network)
    assert graph.route(place(0), place(3))[0] == ["0", "1", "3"]
    assert graph.route(place(0), place(3), {"1"})[0] == ["0", "2", "3"]
    with pytest.raises(NoRouteError, match="closed"):
        graph.route(place(0), place(3), {"1", "2"})
    with pytest.raises(NoRouteError, match="no way"):
        graph.route(place(3), place(0))


def test_drawn_places_depend_on_the_seed_only():
    graph = LaneGraph(_LOOP)
    assert drawn_places(graph, 3) == drawn_places(graph, 3) != drawn_places(graph, 4)
    start, goal = drawn_places(graph, 3, (20.0, 0.0))
    assert start == (20.0, 0.0) and goal != start
    with pytest.raises(NoRouteError, match="no way of 100 m"):
        drawn_places(LaneGraph(network_of([50.0], [])), 3)
