"""Check of the lane filter: it must mark the lines of a road, and nothing else."""

from __future__ import annotations

from typing import Iterator

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.camera_subject import THRESHOLDS
from sdc_workshop.exam.library_subjects import LibrarySubject

_TOP = int(480 * THRESHOLDS["horizon_fraction"])
_EITHER = (
    "A pixel is a marking if it is steep or colourful: cv2.bitwise_or of self._steep(bgr) and "
    "self._colourful(bgr)."
)


class LaneFilterSubject(LibrarySubject):
    """lane_filter.py, TODO 5."""

    module = "lane_filter"
    todos = ("5",)

    def _problems(self, found: dict) -> Iterator[Problem]:
        sky, asphalt = found["sky"], found["asphalt"]
        white, yellow = found["white_line"], found["yellow_line"]
        if found["shape"] != [480, 640]:
            yield Problem(
                "a mask of 480 x 640",
                f"a mask of {' x '.join(map(str, found['shape']))}",
                "mask already has the size of the picture: assign to its lower part, mask[top:], "
                f"below the horizon (row {_TOP} here).",
                "5",
            )
        elif sky:
            yield Problem(
                f"no marking above the horizon (row {_TOP} of 480)",
                f"{sky} pixels are marked there",
                "Mark pixels below the horizon only: mask[top:] is the part below it.",
                "5",
            )
        elif not white and not yellow:
            yield Problem(
                "the edges of a white line and the area of a yellow one are marked",
                "nothing is marked",
                f"{_EITHER} Where both must be true (and), almost nothing is left. Assign the "
                "result to mask[top:], the part below the horizon.",
                "5",
            )
        elif not white:
            yield Problem(
                "the edges of a white line are marked",
                "only colours are marked",
                f"{_EITHER} White is not colourful, but its edges are steep.",
                "5",
            )
        elif not yellow:
            yield Problem(
                "the area of a yellow line is marked", "only steep edges are marked", _EITHER, "5"
            )
        elif asphalt:
            yield Problem(
                "asphalt is not marked",
                f"{asphalt} pixels of it are",
                "Only pixels that are steep or colourful are marked: is the result inverted?",
                "5",
            )
