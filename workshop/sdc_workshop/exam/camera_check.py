"""Check of the camera node: it gets a picture of a road and must find its lane markings."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from typing import TYPE_CHECKING

from sdc_sim.yaml_document import packaged_config
from sdc_workshop.exam.answer import Answer, listed
from sdc_workshop.exam.files import interpreter_problem, permission_problem
from sdc_workshop.exam.node import Node, running_node
from sdc_workshop.exam.node_check import NodeCheck
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE, SOLUTION

if TYPE_CHECKING:
    import numpy as np
    from sensor_msgs.msg import Image

PICTURES = "/carla/ego_vehicle/camera/rgb/front/image_color"
MASKS = "/camera/lane_mask"
TITLE = "camera: F"
# So many different pictures may be seen in a window before it counts as wrong.
_MAX_PICTURES = 20
# So many pixels of a mask may differ.
_MAX_DIFFERENT = 20
_THRESHOLDS = {"gradient": 70, "saturation": 90, "lightness": 110, "horizon_fraction": 0.52}


class CameraCheck(NodeCheck):
    """camera.py, TODO 1 to 4."""

    file = f"{PACKAGE}/scripts/camera.py"
    todos = ("1", "2", "3", "4")
    init_todo = "2"
    given_topics = (MASKS,)
    topics = (
        ("publishes", MASKS, "sensor_msgs/Image", None),
        ("subscribes", PICTURES, "sensor_msgs/Image", "3"),
    )
    answer = "a mask for each picture"

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See RegionCheck.problems."""
        if "1" in variant.judged:
            found = interpreter_problem(
                variant.text, ("python3",), "#!/usr/bin/env python3"
            ) or permission_problem(stage.student, self.file)
            if found is not None:
                return [replace(found, todo="1", line=1)]
            if variant.judged == ("1",):
                return []
        problems = super().problems(variant, stage)
        if not problems and "4" in variant.judged and stage.display is not None:
            window = self._window_problem(variant, stage)
            return [window] if window is not None else []
        return problems

    def parameters(self, stage: Stage) -> dict:
        """See NodeCheck.parameters."""
        # The packages of ROS are those of the terminal, which may lack the car.
        offset = packaged_config("camera", str(SOLUTION / PACKAGE / "config"))["lane_offset"]
        return {"show_window": False, "lane_filter": _THRESHOLDS, "lane_offset": offset}

    def answer_problem(self, node: Node, variant: Variant, stage: Stage) -> Answer | None:
        """See NodeCheck.answer_problem."""
        import numpy as np
        from sensor_msgs.msg import Image

        from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds
        from sdc_workshop.exam.probes.road_picture import road

        masks, pictures = node.subscriber(MASKS, Image), node.publisher(PICTURES, Image)
        random = stage.random(self.file)
        picture = road(random.randint(250, 350), random.randint(10, 40))
        message = _road_message(picture)
        how = node.send_until(lambda: pictures.publish(message), lambda: masks.messages)
        if not masks.messages:
            return self.silence_problem(node, how, variant)
        if masks.messages[0].header.frame_id != message.header.frame_id:
            return listed("header")
        mask = np.frombuffer(masks.messages[0].data, np.uint8)
        wanted = LaneFilter(LaneFilterThresholds(**_THRESHOLDS)).mask(picture).ravel()
        if mask.shape == wanted.shape and np.count_nonzero(mask != wanted) <= _MAX_DIFFERENT:
            return None
        return listed("mask")

    def _window_problem(self, variant: Variant, stage: Stage) -> Answer | None:
        import numpy as np
        from sensor_msgs.msg import Image

        from sdc_workshop.exam.probes.road_picture import road

        display = stage.display
        assert display is not None
        environment = {"DISPLAY": display.environment["DISPLAY"], "SDL_AUDIODRIVER": "dummy"}
        parameters = {**self.parameters(stage), "show_window": True}
        with running_node(stage, variant, parameters, **environment) as node:
            pictures = node.publisher(PICTURES, Image)
            message = _road_message(road())
            shown: list = []

            def is_right() -> bool:
                return bool(shown) and np.abs(shown[-1] - road()[400, 305, :3]).max() < 8

            def is_decided() -> bool:
                # While a window opens, it may be missing or smaller for a moment.
                with contextlib.suppress(LookupError):
                    for window in display.windows(TITLE)[:1]:
                        shown.append(display.picture(window)[400, 305].astype(int))
                # A window is black until its first picture.
                return is_right() or sum(colour.any() for colour in shown) > _MAX_PICTURES

            node.send_until(lambda: pictures.publish(message), is_decided)
            if is_right():
                return None
            return self.crash_problem(node, variant) or listed(
                "window", title=TITLE, seen="another picture" if shown else "no such window"
            )


def _road_message(picture: np.ndarray) -> Image:
    """Return the picture of a road as a message."""
    from cv_bridge import CvBridge

    message = CvBridge().cv2_to_imgmsg(picture, "bgra8")
    message.header.frame_id = "a picture of the check"
    return message
