"""Find the input of the controller that has timed out."""

from __future__ import annotations

from sdc_common.validation import check_positive

ODOMETRY, PATH = "odometry", "path"


class InputWatchdog:
    """Timeouts of odometry and local path, in simulated time.

    Times are stamps in integer nanoseconds, so that ages are exact. The age of the path is measured
    from odometry to odometry: the clock arrives on a separate connection and may be ahead of the
    odometry or behind it.

    Args:
        timeout_s: maximum age of an input, positive, or a ValueError names patience_s [s]
    """

    def __init__(self, timeout_s: float):
        check_positive(patience_s=timeout_s)
        self._timeout_ns = round(timeout_s * 1e9)
        self._odometry_ns = 0
        self._path_ns = 0

    def odometry_received(self, stamp_ns: int) -> None:
        """Record an odometry with this stamp [ns]."""
        self._odometry_ns = stamp_ns

    def path_received(self) -> None:
        """Record the path that answers the last odometry."""
        self._path_ns = self._odometry_ns

    @property
    def path_timed_out(self) -> bool:
        """Return whether a path has arrived before, and is now older than the timeout."""
        return self._path_ns > 0 and self._odometry_ns - self._path_ns > self._timeout_ns

    def timed_out(self, now_ns: int, path_needed: bool = True) -> str | None:
        """Return the input that has timed out by now [ns], `odometry` before `path`, or None."""
        if now_ns - self._odometry_ns > self._timeout_ns:
            return ODOMETRY
        if path_needed and self._odometry_ns - self._path_ns > self._timeout_ns:
            return PATH
        return None
