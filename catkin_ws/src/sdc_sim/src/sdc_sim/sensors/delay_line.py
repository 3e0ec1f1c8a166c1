"""A delay line for measurements and commands."""

from __future__ import annotations

import math
from collections import deque
from typing import Any

from sdc_common.validation import check_non_negative, check_positive


class DelayLine:
    """Returns each item a fixed number of ticks after it was put in.

    Args:
        delay_s: delay; it is rounded to whole ticks, halves upwards
        tick_s: duration of a tick

    Raises:
        ValueError: the delay is negative or the tick not positive, or one of them is not a number
    """

    def __init__(self, delay_s: float, tick_s: float):
        check_non_negative(delay_s=delay_s)
        check_positive(tick_s=tick_s)
        # 1e-9 compensates rounding: 0.15 / 0.1 is 1.4999..., but 1.5 ticks are rounded to 2.
        self.ticks = int(math.floor(delay_s / tick_s + 0.5 + 1e-9))
        self._line: deque[Any] = deque()

    def put(self, item: Any) -> Any:
        """Put in the item of this tick; return that of `ticks` ticks ago, None until it fills."""
        self._line.append(item)
        return self._line.popleft() if len(self._line) > self.ticks else None

    def clear(self) -> None:
        """Remove all items."""
        self._line.clear()
