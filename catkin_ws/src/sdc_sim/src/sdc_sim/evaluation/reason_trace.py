"""What limited the speed in each tick of a drive."""

from __future__ import annotations

from bisect import bisect_right

from sdc_common.planning.speed_reasons import REPEAT_NS

# A message applies until the next one, but no longer than this after its stamp.
_VALID_NS = 1_000_000_000
_MAX_NAME_LENGTH = 40
# Messages that are later than every tick would fill the memory.
_MAX_MESSAGES = 5000


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

    def is_late(self, stamp_ns: int) -> bool:
        """Return whether a message up to this stamp is on its way: the last one is repeated."""
        return bool(self._stamps) and stamp_ns - self._stamps[-1] >= REPEAT_NS

    def forget_before(self, stamp_ns: int) -> None:
        """Remove the messages that no tick from this stamp on needs."""
        old = max(bisect_right(self._stamps, stamp_ns) - 1, 0)
        del self._stamps[:old], self._names[:old]
        del self._stamps[_MAX_MESSAGES:], self._names[_MAX_MESSAGES:]
