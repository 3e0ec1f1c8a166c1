"""Driving by hand: keys held for a while become throttle, brake and steer, as in the client that comes with CARLA."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Collection

from sdc_common.validation import check_between, check_positive
from sdc_sim.physics.vehicle import VehicleCommand

THROTTLE_KEYS = frozenset({"w", "up"})
BRAKE_KEYS = frozenset({"s", "down"})
LEFT_KEYS = frozenset({"a", "left"})
RIGHT_KEYS = frozenset({"d", "right"})
HAND_BRAKE_KEY = "space"
REVERSE_KEY = "q"
AUTOPILOT_KEY = "p"
VIEW_KEY = "tab"
RESET_KEY = "backspace"
HUD_KEY = "f1"
HELP_KEY = "h"
QUIT_KEY = "escape"

HELP = (
    ("W, Up", "throttle"),
    ("S, Down", "brake"),
    ("A, Left", "steer left"),
    ("D, Right", "steer right"),
    ("Q", "reverse gear on or off"),
    ("Space", "hand brake"),
    ("P", "hand back to the stack, or take over"),
    ("TAB", "next view: camera, lane mask, map"),
    ("Backspace", "back to the start of the route"),
    ("F1", "figures (HUD) on or off"),
    ("H", "this help"),
    ("Esc", "quit"),
)


@dataclass(frozen=True)
class KeyboardControlRates:
    """How fast a held key acts, and how far. Rates are command units (pedals 0..1, steer -1..1) per second.

    Raises ValueError unless all rates are positive and steer_limit lies in 0..1.
    """

    throttle_per_s: float
    brake_per_s: float
    steer_per_s: float
    steer_return_per_s: float
    steer_limit: float

    def __post_init__(self):
        check_positive(**vars(self))
        check_between(0.01, 1.0, steer_limit=self.steer_limit)


class KeyboardControl:
    """Turns the names of the keys that are held (pygame's: "w", "up", "space") into a command.

    A pedal comes while its key is held and is free at once when it is let go. Steering builds up while a key is held, returns to
    the middle when none is, or both are, and passes through the middle when the other one is. Reverse stays until it is toggled.
    Source: PythonAPI/examples/manual_control.py of CARLA, `_parse_vehicle_keys`; there the wheel is in the middle at once.
    """

    def __init__(self, rates: KeyboardControlRates):
        self.rates = rates
        self.reset()

    def reset(self) -> None:
        """No pedal, the wheel in the middle, the forward gear."""
        self.command = VehicleCommand()

    def toggle_reverse(self) -> None:
        """Change between the forward and the reverse gear."""
        last = self.command
        self.command = VehicleCommand(
            last.throttle, last.steer, last.brake, last.hand_brake, not last.reverse
        )

    def step(self, held: Collection[str], step_s: float) -> VehicleCommand:
        """The command after the keys `held` were held for `step_s` seconds. Raises ValueError for a negative or infinite time."""
        if not 0.0 <= step_s < math.inf:
            raise ValueError(f"a time step must not be negative or infinite, got {step_s}")
        held = set(held)
        last = self.command
        direction = bool(held & RIGHT_KEYS) - bool(held & LEFT_KEYS)
        self.command = VehicleCommand(
            throttle=min(1.0, last.throttle + self.rates.throttle_per_s * step_s)
            if held & THROTTLE_KEYS
            else 0.0,
            steer=self._steer(last.steer, direction, step_s),
            brake=min(1.0, last.brake + self.rates.brake_per_s * step_s)
            if held & BRAKE_KEYS
            else 0.0,
            hand_brake=HAND_BRAKE_KEY in held,
            reverse=last.reverse,
        )
        return self.command

    def _steer(self, steer: float, direction: int, step_s: float) -> float:
        if direction * steer <= 0.0 and steer != 0.0:
            back = min(abs(steer), self.rates.steer_return_per_s * step_s)
            steer -= math.copysign(back, steer)
            step_s -= back / self.rates.steer_return_per_s
        limit = self.rates.steer_limit
        return min(max(steer + direction * self.rates.steer_per_s * step_s, -limit), limit)
