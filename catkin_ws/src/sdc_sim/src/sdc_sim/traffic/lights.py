"""The traffic lights of a map, as those of a scenario."""

from __future__ import annotations

from typing import Any, Callable, Iterator

from sdc_map.mirror import negated
from sdc_map.network import Junction, Network, edge_of
from sdc_map.network_file import load_network
from sdc_sim.physics.traffic_lights import TrafficLightPlan

# By the letters of SUMO; the first of the colours is the most restrictive one.
_COLOURS = {"G": "green", "g": "green", "y": "yellow", "u": "red", "r": "red", "s": "red"}
_ORDER = ("red", "yellow", "off", "green")
_AHEAD_M = (4.0, 2.5, 1.0, 0.0)  # places of a pole beyond the stop line
_BESIDE_M = 0.8  # distance of the first pole to the road
_APART_M = 0.5  # distance between poles


def of_map(path: str) -> list[TrafficLightPlan]:
    """Return a light for each lane that ends at one.

    It shows the colour of the most restricted way on: a lane has one row of lamps, also where SUMO
    has an arrow for some of its ways.

    Raises:
        MapError: the map cannot be read
    """
    return lights_of(load_network(path))


def lights_of(network: Network) -> list[TrafficLightPlan]:
    """Return the lights of a network; see `of_map`."""
    right = network.right_hand
    junctions = [junction for junction in right.junctions.values() if junction.phases]
    lights = [light for junction in junctions for light in _lights(right, junction)]
    if network is right:
        return lights
    return [negated(light, "y_m", "heading_rad", "pole_right_m") for light in lights]


def _lights(network: Network, junction: Junction) -> Iterator[TrafficLightPlan]:
    signals: dict[str, list[int]] = {}
    for connection in junction.connections:
        if connection.signal >= 0:
            signals.setdefault(connection.start, []).append(connection.signal)
    rows: dict[str, list] = {}  # the rows of lamps beside each road
    for name, of_lane in signals.items():
        lane = network.lanes[name]
        phases = _phases(junction, of_lane, min)
        if "green" not in [colour for colour, _ in phases]:  # its ways are open one after another
            phases = _phases(junction, of_lane, max)
        (x_m, y_m), z_m = lane.points_m[-1].tolist(), float(lane.z_m[-1])
        heading = lane.heading_at(lane.length_m)
        beside = rows.setdefault(edge_of(name), [])
        if phases not in beside:
            beside.append(phases)
        right_m = 0.5 * lane.width_m + _BESIDE_M + _APART_M * beside.index(phases)
        while lane.right:
            lane = network.lanes[lane.right]
            right_m += lane.width_m
        for ahead_m in _AHEAD_M:
            row = x_m, y_m, heading, phases, -junction.offset_s, ahead_m, right_m, z_m
            light = TrafficLightPlan(*row)
            place = network.nearest(*light.pole_m, z_m=z_m)
            if place is None or abs(place.cross_track_m) > 0.5 * network.lanes[place.lane].width_m:
                break  # The pole is on no lane.
        yield light


def _phases(junction: Junction, signals: list[int], choose: Callable) -> Any:
    return tuple(
        (
            choose((_COLOURS.get(letters[signal], "off") for signal in signals), key=_ORDER.index),
            seconds,
        )
        for seconds, letters in junction.phases
    )
