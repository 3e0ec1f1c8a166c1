#!/usr/bin/env python3
"""Traffic light detector: find the lights in each picture of the front camera, and publish them."""

from sdc_perception.msg import DetectedLight, DetectedLights

from sdc_perception.light_detection import LightSettings
from sdc_perception.light_tracker import LightTracker
from sdc_perception.picture_detector import PictureDetectorNode


def lights_message(lights):
    return DetectedLights(lights=[DetectedLight(*light) for light in lights])


if __name__ == "__main__":
    PictureDetectorNode(
        "traffic_light_detector",
        LightSettings.read,
        "/perception/traffic_lights",
        DetectedLights,
        LightTracker,
        lights_message,
    ).run()
