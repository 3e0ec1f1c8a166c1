"""Turn held keys into throttle, brake and steer, as in the client that comes with CARLA."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Collection

from sdc_common.driving import Command
from sdc_common.validation import check_between, check_positive
from sdc_sim.yaml_document import packaged_config

_ROWS = packaged_config("keys")
# What each key does, and the lines of the help.
ACTIONS: dict[str, str] = {key: action for action, row in _ROWS.items() for key in row["keys"]}
HELP = [(row["shown"], row["help"]) for row in _ROWS.values()]


@dataclass(frozen=True)
class KeyboardControlRates:
    """How fast the command changes while a key is held [1/s], and the maximum steer.

    Raises:
        ValueError: a rate is not positive, or steer_limit is not from 0.01 to 1.
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
    """Turns the names of held keys (pygame's names: "w", "up", "space") into a command.

    A pedal value rises while its key is held and is zero as soon as the key is released. The steer
    value grows while a key is held. It returns to zero while no key or both keys are held, and
    crosses zero when the opposite key is held. Reverse stays until it is toggled.

    Reference: PythonAPI/examples/manual_control.py of CARLA, `_parse_vehicle_keys`. CARLA's client
    resets the steer value to zero at once.
    """

    def __init__(self, rates: KeyboardControlRates):
        self.rates = rates
        self.reset()

    def reset(self) -> None:
        """Release the pedals, centre the steering and select the forward gear."""
        self.command = Command()

    def toggle_reverse(self) -> None:
        """Switch between the forward and the reverse gear."""
        self.command = replace(self.command, reverse=not self.command.reverse)

    def step(self, held: Collection[str], step_s: float) -> Command:
        """Return the command after these keys were held for a time step."""
        actions = {ACTIONS.get(key) for key in held}
        last = self.command
        direction = ("right" in actions) - ("left" in actions)
        throttle = min(1.0, last.throttle + self.rates.throttle_per_s * step_s)
        brake = min(1.0, last.brake + self.rates.brake_per_s * step_s)
        self.command = Command(
            throttle if "throttle" in actions else 0.0,
            self._steer(last.steer, direction, step_s),
            brake if "brake" in actions else 0.0,
            hand_brake="hand_brake" in actions,
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
