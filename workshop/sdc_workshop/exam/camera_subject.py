"""The camera node and its lane filter: shown a road, they are to find its lines."""

from __future__ import annotations

import contextlib

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.files import interpreter_problem, permission_problem
from sdc_workshop.exam.node_subject import NodeSubject, refusal
from sdc_workshop.exam.probe import probe
from sdc_workshop.exam.subject import Subject
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE

PICTURES = "/carla/ego_vehicle/camera/rgb/front/image_color"
MASKS = "/camera/lane_mask"
TITLE = "camera: F"
# So often a window may show another picture than the one that was sent, before it counts as wrong.
_LOOKS = 20
THRESHOLDS = {"gradient": 70, "saturation": 90, "lightness": 110, "horizon_fraction": 0.52}


class CameraSubject(NodeSubject):
    """camera.py, TODO 1 to 4."""

    file = f"{PACKAGE}/scripts/camera.py"
    todos = ("1", "2", "3", "4")
    init_todo = "2"
    usual_topics = (MASKS,)

    def problems(self, variant: Variant, stage) -> list:
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

    def _problem(self, variant, stage):
        import numpy as np
        from cv_bridge import CvBridge
        from sensor_msgs.msg import Image

        from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds
        from sdc_workshop.exam.probes.road_picture import road

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
            masks, pictures = node.listener(MASKS, Image), node.publisher(PICTURES, Image)
            message = CvBridge().cv2_to_imgmsg(road(), "bgra8")
            message.header.frame_id = "a picture of the check"
            how = node.ask(lambda: pictures.publish(message), lambda: masks.messages)
            if not masks.messages:
                return self._silence(node, how, variant)
            mask = np.frombuffer(masks.messages[0].data, np.uint8)
            wanted = LaneFilter(LaneFilterThresholds(**THRESHOLDS)).mask(road())
            if masks.messages[0].header.frame_id != message.header.frame_id:
                return Problem(
                    "the mask carries the header of its picture",
                    "another header",
                    "publish(mask, message.header) hands it on.",
                    "4",
                )
            if mask.shape != (wanted.size,) or np.count_nonzero(mask != wanted.ravel()) > 20:
                return Problem(
                    "the mask of the lane filter for this picture",
                    "another mask",
                    'Is the picture turned into "bgra8" (blue, green, red, alpha: as the car sends it), and does mask come from '
                    "self.lane_filter.mask(image)?",
                    "4",
                )
        return None

    def _silence(self, node, how, variant):
        found = self.crash_problem(node, variant)
        if found is not None:
            return found
        said = refusal(node)
        if said is not None:
            return Problem(
                "a mask for each picture, from a picture that came as bgra8",
                f"the node says: {said}",
                'The filter wants colours: imgmsg_to_cv2(message, "bgra8") gives blue, green, red and alpha.',
                "4",
            )
        if how == "busy":
            return Problem(
                "a mask for each picture",
                "the callback runs in circles",
                "Is there a loop in it that never ends?",
                "4",
            )
        return Problem(
            f"a mask on {MASKS} for a picture on {PICTURES}",
            "the picture came, and nothing happened",
            "The subscriber's third argument is the function that is called for each picture: self.on_image."
            if "4" not in variant.judged
            else "After this region `mask` is published: nothing before it may return.",
            "3" if "4" not in variant.judged else "4",
        )

    def _window_problem(self, variant, stage):
        import numpy as np
        from cv_bridge import CvBridge
        from sensor_msgs.msg import Image

        from sdc_workshop.exam.probes.road_picture import road

        display = stage.display
        with stage.node(
            variant,
            {"show_window": True, "lane_filter": THRESHOLDS},
            DISPLAY=display.environment["DISPLAY"],
            SDL_AUDIODRIVER="dummy",
        ) as node:
            pictures = node.publisher(PICTURES, Image)
            message = CvBridge().cv2_to_imgmsg(road(), "bgra8")
            shown = []

            def is_right():
                return bool(shown) and np.abs(shown[-1] - road()[400, 305, :3]).max() < 8

            def is_decided():
                # A window that opens may be made anew, and be gone or smaller for a moment.
                with contextlib.suppress(LookupError):
                    for window in display.windows(TITLE)[:1]:
                        shown.append(display.picture(window)[400, 305].astype(int))
                # A window is black until the first picture comes.
                return is_right() or sum(colour.any() for colour in shown) > _LOOKS

            node.ask(lambda: pictures.publish(message), is_decided)
            if is_right():
                return None
            found = self.crash_problem(node, variant)
            if found is not None:
                return found
            return Problem(
                f"a window '{TITLE} ...' that shows the picture",
                "another picture" if shown else "no such window",
                'The window shows what stands in `image`: blue, green, red and alpha, "bgra8", as the picture came.',
                "4",
            )


class LaneFilterSubject(Subject):
    """lane_filter.py, TODO 5."""

    file = f"{PACKAGE}/src/{PACKAGE}/lane_filter.py"
    todos = ("5",)

    def problems(self, variant: Variant, stage) -> list:
        found = probe(variant, stage, "lane_filter")
        if isinstance(found, Problem):
            return [found]
        top = int(480 * THRESHOLDS["horizon_fraction"])
        white, yellow, sky, road_between, shape = (
            found["white_line"],
            found["yellow_line"],
            found["sky"],
            found["asphalt"],
            found["shape"],
        )
        if shape != [480, 640]:
            return [
                Problem(
                    "a mask of 480 x 640",
                    f"a mask of {' x '.join(map(str, shape))}",
                    f"mask already has the size of the picture: fill its lower part, mask[top:], below the horizon (row {top} here).",
                    "5",
                )
            ]
        if sky:
            return [
                Problem(
                    f"nothing above the horizon (row {top} of 480)",
                    f"{sky} pixels are marked there",
                    "Only what is below the horizon may be marked: mask[top:] is the part below it.",
                    "5",
                )
            ]
        if not white and not yellow:
            return [
                Problem(
                    "the edges of a white line and the area of a yellow one are marked",
                    "nothing is marked",
                    "A pixel is a marking where it is steep or colourful: cv2.bitwise_or. Where both must be true (and), hardly any is "
                    "left. The result belongs into mask[top:], below the horizon.",
                    "5",
                )
            ]
        if not white:
            return [
                Problem(
                    "the edges of a white line are marked",
                    "they are not: only colours are",
                    "A pixel is a marking where it is steep or colourful: cv2.bitwise_or of self._steep(bgr) and self._colourful(bgr). "
                    "White is not colourful, its edges are steep.",
                    "5",
                )
            ]
        if not yellow:
            return [
                Problem(
                    "the area of a yellow line is marked",
                    "it is not: only steep edges are",
                    "A pixel is a marking where it is steep or colourful: cv2.bitwise_or of self._steep(bgr) and self._colourful(bgr).",
                    "5",
                )
            ]
        if road_between:
            return [
                Problem(
                    "bare asphalt is not marked",
                    f"{road_between} pixels of it are",
                    "Marked is what is steep or colourful, and nothing else: is the result turned round?",
                    "5",
                )
            ]
        return []
