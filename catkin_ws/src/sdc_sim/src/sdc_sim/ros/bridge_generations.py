"""The generations of the CARLA ROS bridge: message classes, topics and frames that differ.

A generation has the topics of all bridges up to the next one; docs/bridge.md lists them.
"""

from __future__ import annotations

from typing import Mapping, NamedTuple

import carla_msgs.msg
from carla_msgs.msg import CarlaEgoVehicleControl
from sdc_msgs.msg import CarlaVehicleControl
from std_msgs.msg import String


class CameraNames(NamedTuple):
    """Topics and frame of a camera, below the name of the vehicle."""

    image: str
    camera_info: str
    frame: str


class SensorNames(NamedTuple):
    """Topic and frame of a sensor, below the name of the vehicle."""

    topic: str
    frame: str


class BridgeGeneration(NamedTuple):
    """What differs between the generations.

    Attributes:
        control_class: message class of the control commands
        map_class: message class of /carla/map; None where that topic does not exist
        front: the front camera
        view: the camera behind the vehicle; None where the bridge has none
        spectator: the camera that a person moves; None where the bridge has none
        topics: topics that not every generation has. A name without /carla is one of the vehicle
        sensors: the sensors by their names in config/sim.yaml
    """

    control_class: type
    map_class: type | None
    front: CameraNames
    view: CameraNames | None
    spectator: CameraNames | None
    topics: frozenset[str]
    sensors: Mapping[str, SensorNames]


def _by_kind(name: str) -> CameraNames:
    """Return the names of an RGB camera in bridges up to 0.9.10, with its kind."""
    frame = "/camera/rgb/" + name
    return CameraNames(frame + "/image_color", frame + "/camera_info", frame)


def _by_name(name: str) -> CameraNames:
    """Return the names of a camera in bridges from 0.9.11 on, with its name alone."""
    return CameraNames(f"/{name}/image", f"/{name}/camera_info", f"/{name}")


# No bridge has wheel speeds. The names of the planar lidar follow those of the other lidar.
_NEWEST = {
    "imu": SensorNames("/imu", "/imu"),
    "gnss": SensorNames("/gnss", "/gnss"),
    "speedometer": SensorNames("/speedometer", ""),
    "lidar": SensorNames("/lidar", "/lidar"),
    "planar_lidar": SensorNames("/lidar_planar", "/lidar_planar"),
    "wheel_speeds": SensorNames("/wheel_speeds", ""),
}
_0_9_3 = BridgeGeneration(
    CarlaVehicleControl,
    String,
    _by_kind("front"),
    None,
    None,
    frozenset({"/carla/objects", "/carla/vehicle_marker", "/ego_vehicle_control_info"}),
    {
        **_NEWEST,
        "gnss": SensorNames("/gnss/front/gnss", "/gnss/front"),
        "lidar": SensorNames("/lidar/front/point_cloud", "/lidar/front"),
        "planar_lidar": SensorNames("/lidar/planar/point_cloud", "/lidar/planar"),
    },
)
_0_9_5 = BridgeGeneration(
    CarlaEgoVehicleControl,
    # The installed package of a later bridge does not have this message.
    getattr(carla_msgs.msg, "CarlaMapInfo", None),
    _by_kind("front"),
    _by_kind("view"),
    _by_kind("spectator_view"),
    frozenset(
        {
            "/carla/objects",
            "/objects",
            "/carla/actor_list",
            "/carla/vehicle_marker",
            "/carla/marker",
            "/carla/traffic_lights",
            "/carla/traffic_lights_info",
            "/carla/weather_control",
            "/twist_cmd",
        }
    ),
    {
        **_NEWEST,
        "imu": SensorNames("/imu/imu1", "/imu/imu1"),
        "gnss": SensorNames("/gnss/gnss1/fix", "/gnss/gnss1"),
        "lidar": SensorNames("/lidar/lidar1/point_cloud", "/lidar/lidar1"),
        "planar_lidar": SensorNames("/lidar/lidar2/point_cloud", "/lidar/lidar2"),
    },
)
_0_9_11 = BridgeGeneration(
    CarlaEgoVehicleControl,
    String,
    _by_name("rgb_front"),
    _by_name("rgb_view"),
    _by_name("spectator_view"),
    frozenset(
        {
            "/carla/objects",
            "/objects",
            "/carla/actor_list",
            "/speedometer",
            "/carla/weather_control",
            "/control/set_transform",
            "/control/set_target_velocity",
        }
    ),
    _NEWEST,
)
GENERATIONS = {
    "0.9.3": _0_9_3,
    "0.9.5": _0_9_5,
    "0.9.11": _0_9_11,
    "old": _0_9_3,
    "new": _0_9_11,
}
