"""What limited the speed in each tick of a drive."""

from __future__ import annotations

from bisect import bisect_right

# A message applies until the next one, but no longer than this after its stamp.
_VALID_NS = 1_000_000_000
_MAX_NAME_LENGTH = 40


class ReasonTrace:
    """The reasons that the driving software published, by the stamp from which on they apply."""

    def __init__(self):
        self._stamps: list[int] = []
        self._names: list[str] = []

    def add(self, stamp_ns: int, name: str) -> None:
        """Add a reason; of two with the same stamp, the later one applies."""
        place = bisect_right(self._stamps, stamp_ns)
        self._stamps.insert(place, stamp_ns)
        self._names.insert(place, name[:_MAX_NAME_LENGTH])

    def at(self, stamp_ns: int) -> str:
        """Return the reason at this stamp; "" if it is unknown."""
        place = bisect_right(self._stamps, stamp_ns) - 1
        if place < 0 or stamp_ns - self._stamps[place] > _VALID_NS:
            return ""
        return self._names[place]
