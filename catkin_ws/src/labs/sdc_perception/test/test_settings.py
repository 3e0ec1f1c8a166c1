"""A parameter that is not valid is named."""

import math

import pytest

from sdc_common.configuration import node_config
from sdc_perception.lane_detection import DetectorSettings
from sdc_perception.light_detection import LightSettings
from sdc_perception.obstacle_detection import ObstacleSettings
from sdc_perception.traffic_following import TrafficSettings

READERS = {
    "lane_detector": DetectorSettings.read,
    "obstacle_detector": ObstacleSettings.read,
    "traffic_follower": TrafficSettings.read,
    "traffic_light_detector": LightSettings.read,
}
CAR = {**node_config("sdc_perception", "obstacle_detector")["kinds"]["car"], "saturation": 300}


@pytest.mark.parametrize(
    ("node", "section", "value", "named"),
    [
        ("lane_detector", "directions", [{"from_m": 1.0, "to_m": 2.0, "keep": "middle"}], "direct"),
        ("lane_detector", "directions", [{"from_m": 1.0}], "directions"),
        ("lane_detector", "lane", {"lane_width_m": -3.5}, "lane_width_m"),
        ("lane_detector", "camera", {"z_m": math.nan}, "z_m"),
        ("obstacle_detector", "kinds", {"car": CAR}, "kinds/car: saturation"),
        ("traffic_light_detector", "lamps", {"red": [172]}, "lamps/red"),
        ("traffic_light_detector", "lamps", {"excess": 1.5}, "excess"),
        ("traffic_light_detector", "housing", {"height_m": -1.0}, "height_m"),
        ("traffic_light_detector", "tracks", {"lost_s": 0.0}, "lost_s"),
        ("traffic_follower", "pole", {"tolerance_m": 0.0}, "tolerance_m"),
        ("traffic_follower", "caution", {"gap_m": -1.0}, "gap_m"),
        ("traffic_follower", "pole", {"right_m": math.inf}, "right_m"),
    ],
)
def test_bad_parameter_is_refused(node, section, value, named):
    configs = node_config("sdc_package", "local_planner"), node_config("sdc_perception", node)
    parameters = {name: one for config in configs for name, one in config.items()}
    if isinstance(value, dict):
        value = {**parameters[section], **value}
    parameters[section] = value
    with pytest.raises(ValueError, match=named):
        READERS[node](parameters.__getitem__)
