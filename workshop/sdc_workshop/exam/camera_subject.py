"""Check of the camera node: it gets a picture of a road and must find its lane markings."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.files import interpreter_problem, permission_problem
from sdc_workshop.exam.node import Node, Received
from sdc_workshop.exam.node_subject import ENDLESS_LOOP, NodeSubject, refusal
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE

if TYPE_CHECKING:
    from sensor_msgs.msg import Image

PICTURES = "/carla/ego_vehicle/camera/rgb/front/image_color"
MASKS = "/camera/lane_mask"
TITLE = "camera: F"
# So many different pictures may be seen in a window before it counts as wrong.
_MAX_PICTURES = 20
# So many pixels of a mask may differ.
_MAX_DIFFERENT = 20
THRESHOLDS = {"gradient": 70, "saturation": 90, "lightness": 110, "horizon_fraction": 0.52}


class CameraSubject(NodeSubject):
    """camera.py, TODO 1 to 4."""

    file = f"{PACKAGE}/scripts/camera.py"
    todos = ("1", "2", "3", "4")
    init_todo = "2"
    usual_topics = (MASKS,)

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See Subject.problems."""
        if "1" in variant.judged:
            found = interpreter_problem(
                variant.text, ("python3",), "#!/usr/bin/env python3"
            ) or permission_problem(stage.student, self.file)
            if found is not None:
                return [Problem(found.expected, found.seen, found.hint, "1", 1)]
            if variant.judged == ("1",):
                return []
        found = self._problem(variant, stage)
        if found is None and "4" in variant.judged and stage.display is not None:
            found = self._window_problem(variant, stage)
        return [found] if found is not None else []

    def _problem(self, variant: Variant, stage: Stage) -> Problem | None:
        from sensor_msgs.msg import Image

        with stage.node(variant, {"show_window": False, "lane_filter": THRESHOLDS}) as node:
            how = node.wait_until(lambda: node.subscribes(PICTURES) and node.publishes(MASKS))
            found = self.start_problem(node, how, variant)
            if found is not None:
                return found
            if how == "ended":
                return self.ended_problem(node, variant)
            found = self.subscriber_problem(node, PICTURES, "sensor_msgs/Image", "3")
            if found is not None or variant.judged == ("2",):
                return found
            masks, pictures = node.subscriber(MASKS, Image), node.publisher(PICTURES, Image)
            message = road_message()
            how = node.send_until(lambda: pictures.publish(message), lambda: masks.messages)
            if not masks.messages:
                return self._silence(node, how, variant)
            return self._mask_problem(masks, message)

    @staticmethod
    def _mask_problem(masks: Received, message: Image) -> Problem | None:
        import numpy as np

        from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds
        from sdc_workshop.exam.probes.road_picture import road

        mask = np.frombuffer(masks.messages[0].data, np.uint8)
        wanted = LaneFilter(LaneFilterThresholds(**THRESHOLDS)).mask(road())
        if masks.messages[0].header.frame_id != message.header.frame_id:
            return Problem(
                "the mask has the header of its picture",
                "another header",
                "publish(mask, message.header) copies it.",
                "4",
            )
        right_size = mask.shape == (wanted.size,)
        if right_size and np.count_nonzero(mask != wanted.ravel()) <= _MAX_DIFFERENT:
            return None
        return Problem(
            "the mask of the lane filter for this picture",
            "another mask",
            'Is the picture converted to "bgra8" (blue, green, red, alpha: as the car sends it), '
            "and is mask the result of self.lane_filter.mask(image)?",
            "4",
        )

    def _silence(self, node: Node, how: str, variant: Variant) -> Problem:
        found = self.crash_problem(node, variant)
        if found is not None:
            return found
        logged = refusal(node)
        if logged is not None:
            return Problem(
                "a mask for each picture, from a picture in bgra8",
                f"the node logs: {logged}",
                'The filter needs colours: imgmsg_to_cv2(message, "bgra8") returns blue, green, '
                "red and alpha.",
                "4",
            )
        if how == "busy":
            seen = "the callback never returns"
            return Problem("a mask for each picture", seen, ENDLESS_LOOP, "4")
        expected = f"a mask on {MASKS} for a picture on {PICTURES}"
        seen = "a picture was sent, and no mask was published"
        if "4" in variant.judged:
            hint = "After this region `mask` is published: do not return before."
            return Problem(expected, seen, hint, "4")
        hint = "The third argument of rospy.Subscriber is the callback: self.on_image."
        return Problem(expected, seen, hint, "3")

    def _window_problem(self, variant: Variant, stage: Stage) -> Problem | None:
        import numpy as np
        from sensor_msgs.msg import Image

        from sdc_workshop.exam.probes.road_picture import road

        display = stage.display
        assert display is not None
        with stage.node(
            variant,
            {"show_window": True, "lane_filter": THRESHOLDS},
            DISPLAY=display.environment["DISPLAY"],
            SDL_AUDIODRIVER="dummy",
        ) as node:
            pictures = node.publisher(PICTURES, Image)
            message = road_message()
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
            return self.crash_problem(node, variant) or Problem(
                f"a window '{TITLE} ...' that shows the picture",
                "another picture" if shown else "no such window",
                'The window shows `image`: blue, green, red and alpha, "bgra8", as it was sent.',
                "4",
            )


def road_message() -> Image:
    """Return the picture of the road as a message."""
    from cv_bridge import CvBridge

    from sdc_workshop.exam.probes.road_picture import road

    message = CvBridge().cv2_to_imgmsg(road(), "bgra8")
    message.header.frame_id = "a picture of the check"
    return message
