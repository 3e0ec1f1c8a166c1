"""Who drives: the stack, a browser, or, when that browser vanishes, the brakes."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from sdc_common.driving import Command
from sdc_sim.manual_control.keyboard import KeyboardControl, KeyboardControlRates

STACK, PERSON, BRAKING = "stack", "person", "braking"
_NO_KEYS: Mapping[str, Any] = {"held": ()}
_STANDSTILL_MPS = 0.1
# A longer pause between two updates moves pedals and steer no further than this [s].
_MAX_STEP_S = 0.1


class RemoteDriving:
    """Turns the controls of one viewer into commands; brakes when they stop to arrive.

    All times are seconds of one wall clock that never goes back. Methods may be called in any
    thread.

    Args:
        rates: how fast held keys move pedals and steer
        timeout_s: time without controls after which the car brakes
        braking_limit_s: time after which a braking car is given back though it still moves
    """

    def __init__(self, rates: KeyboardControlRates, timeout_s: float, braking_limit_s: float):
        self._timeout_s = timeout_s
        self._braking_limit_s = braking_limit_s
        self._lock = threading.RLock()
        self._keyboard = KeyboardControl(rates)
        self._controls: Mapping[str, Any] = _NO_KEYS
        self._controls_at_s = self._braking_since_s = self._stepped_at_s = 0.0
        self._command = Command()
        self.mode = STACK
        self.viewer: int | None = None

    @property
    def overrides(self) -> bool:
        """Whether the commands of the stack must be overridden."""
        return self.mode != STACK

    def take(self, viewer: int, now_s: float) -> None:
        """Give the car to a viewer.

        Raises:
            ValueError: another viewer drives
        """
        with self._lock:
            if self.mode == PERSON and self.viewer != viewer:
                raise ValueError(f"viewer {self.viewer} drives; ask them to give the car back")
            if self.mode != PERSON:
                self._keyboard.reset()
                self._command = Command()
                self._controls, self._stepped_at_s = _NO_KEYS, now_s
            self.mode, self.viewer, self._controls_at_s = PERSON, viewer, now_s

    def release(self, viewer: int | None = None) -> None:
        """Give the car back to the stack, if this viewer drives; None: any viewer."""
        with self._lock:
            if viewer in (None, self.viewer):
                self.mode, self.viewer = STACK, None

    def vanish(self, viewer: int, now_s: float) -> None:
        """Brake and then give the car back, if this viewer drives."""
        with self._lock:
            if self.mode == PERSON and self.viewer == viewer:
                self.mode, self._braking_since_s = BRAKING, now_s

    def control(self, viewer: int, controls: Mapping[str, Any], now_s: float) -> None:
        """Store the controls of a viewer, if it drives.

        They are the values of a message "keys" or "pedals", see config/page.yaml.
        """
        with self._lock:
            if self.mode == PERSON and self.viewer == viewer:
                self._controls, self._controls_at_s = controls, now_s

    def toggle_reverse(self, viewer: int) -> None:
        """Switch between the forward and the reverse gear, if this viewer drives."""
        with self._lock:
            if self.mode == PERSON and self.viewer == viewer:
                self._keyboard.toggle_reverse()

    def step(self, now_s: float, speed_mps: float) -> Command | None:
        """Return the command for now, or None while the stack drives."""
        with self._lock:
            if self.mode == PERSON and now_s - self._controls_at_s > self._timeout_s:
                self.mode, self._braking_since_s = BRAKING, now_s
            if self.mode == BRAKING:
                waited_s = now_s - self._braking_since_s
                if abs(speed_mps) < _STANDSTILL_MPS or waited_s > self._braking_limit_s:
                    self.mode, self.viewer = STACK, None
                    return None
                # The steer stays: in a bend, straight wheels leave the road.
                self._command = replace(self._command, throttle=0.0, brake=1.0, hand_brake=False)
                return self._command
            if self.mode == STACK:
                return None
            step_s = min(max(now_s - self._stepped_at_s, 0.0), _MAX_STEP_S)
            self._stepped_at_s = now_s
            self._command = self._wanted(step_s)
            return self._command

    def _wanted(self, step_s: float) -> Command:
        if "held" in self._controls:
            return self._keyboard.step(frozenset(self._controls["held"]), step_s)
        reverse = self._keyboard.command.reverse
        self._keyboard.command = Command(**self._controls, reverse=reverse)
        return self._keyboard.command
