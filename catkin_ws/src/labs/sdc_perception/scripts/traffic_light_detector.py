#!/usr/bin/env python3
"""Traffic light detector: find the lights in each picture of the front camera, and publish them."""

from sdc_perception.msg import DetectedLight, DetectedLights

from sdc_perception.detection_overlay import draw_lights
from sdc_perception.light_tracker import LightSettings, LightTracker
from sdc_perception.picture_detector import PictureDetectorNode


class TrafficLightDetectorNode(PictureDetectorNode):
    def __init__(self):
        topic = "/perception/traffic_lights"
        super().__init__("traffic_light_detector", LightSettings.read, topic, DetectedLights)

    def start(self, intrinsic):
        return LightTracker(self.settings, intrinsic)

    def find(self, image, pose, time_s):
        return self.detector.detect(image, pose, time_s)

    def message(self, lights):
        return DetectedLights(lights=[DetectedLight(*light) for light in lights])

    def drawn(self, image, _pose, _lights):
        return draw_lights(image, self.detector.seen)


if __name__ == "__main__":
    TrafficLightDetectorNode().run()
