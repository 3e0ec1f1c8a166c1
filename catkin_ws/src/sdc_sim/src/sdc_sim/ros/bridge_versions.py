"""What differs between the versions of the CARLA ROS bridge, read from a file."""

from __future__ import annotations

from typing import Any, Mapping, NamedTuple

import roslib.message

from sdc_sim.yaml_document import packaged_config


class CameraNames(NamedTuple):
    """Topics and frame of a camera, below the name of the vehicle."""

    image: str
    camera_info: str
    frame: str


class SensorNames(NamedTuple):
    """Topic and frame of a sensor, below the name of the vehicle."""

    topic: str
    frame: str


class BridgeVersion(NamedTuple):
    """What differs between the versions; config/bridge_versions.yaml describes it.

    Attributes:
        control_class: message class of the control commands
        map_class: message class of /carla/map; None where that topic does not exist
        front: the front camera
        view: the camera behind the vehicle; None where the bridge has none
        spectator: the camera that a person moves; None where the bridge has none
        topics: topics that not every version has. A name without /carla is one of the vehicle
        sensors: the sensors by their names in config/sim.yaml
    """

    control_class: type
    map_class: type | None
    front: CameraNames
    view: CameraNames | None
    spectator: CameraNames | None
    topics: frozenset[str]
    sensors: Mapping[str, SensorNames]


def _read(values: dict[str, Any]) -> BridgeVersion:
    cameras = {name: CameraNames(**names) for name, names in values["cameras"].items()}
    return BridgeVersion(
        roslib.message.get_message_class(values["control_type"]),
        roslib.message.get_message_class(values["map_type"]),
        cameras["front"],
        cameras.get("view"),
        cameras.get("spectator"),
        frozenset(values["topics"]),
        {name: SensorNames(**names) for name, names in values["sensors"].items()},
    )


def _read_all() -> dict[str, BridgeVersion]:
    rows = packaged_config("bridge_versions")
    versions = {name: _read(values) for name, values in rows.items()}
    return {**versions, "old": versions["0.9.3"], "new": versions["0.9.11"]}


BRIDGE_VERSIONS = _read_all()
