"""What differs between the versions of the CARLA ROS bridge: config/bridge_versions.yaml."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from roslib.message import get_message_class

from sdc_sim.yaml_document import packaged_config

# The topics of a camera or sensor, and its frame, below the name of the vehicle, as attributes.
Names = SimpleNamespace
# control_class and map_class: message classes, map_class None where there is no /carla/map;
# front, view and spectator: the cameras, None where the bridge has none; topics: those that not
# every version has; sensors: by their names in config/sim.yaml.
BridgeVersion = SimpleNamespace


def _read(values: dict[str, Any]) -> BridgeVersion:
    cameras = {name: Names(**names) for name, names in values["cameras"].items()}
    return BridgeVersion(
        control_class=get_message_class(values["control_type"]),
        map_class=get_message_class(values["map_type"]),
        **{name: cameras.get(name) for name in ("front", "view", "spectator")},
        topics=frozenset(values["topics"]),
        sensors={name: Names(**names) for name, names in values["sensors"].items()},
    )


BRIDGE_VERSIONS = {
    name: _read(values) for name, values in packaged_config("bridge_versions").items()
}
BRIDGE_VERSIONS["old"], BRIDGE_VERSIONS["new"] = BRIDGE_VERSIONS["0.9.3"], BRIDGE_VERSIONS["0.9.11"]
