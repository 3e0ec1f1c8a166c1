"""Who drives the car: the software, or a person who has taken over; by pedals, or by speed and wheel angle."""

from __future__ import annotations

from sdc_sim.physics.ackermann import AckermannControl, AckermannTarget
from sdc_sim.physics.vehicle import VehicleCommand, VehicleState
from sdc_sim.simulation.sensors import DelayLine


class CommandMux:
    """Keeps the last order of the software and of the person, and tells each tick which command the car obeys.

    patience_ticks is how long an order stays in force without a new one before the car brakes by itself; 0 means for ever.
    While `by_hand` the person's orders rule; the software's are kept, so that the latest of them holds when the car is given
    back. An order reaches the car `latency.ticks` ticks after it was given; the car's own braking does not wait.
    """

    def __init__(self, patience_ticks: int, latency: DelayLine, ackermann: AckermannControl = None):
        self.by_hand = False
        self._patience_ticks = patience_ticks
        self._latency = latency
        self._ackermann = ackermann
        self._orders = {False: None, True: None}
        self._last = VehicleCommand()

    @property
    def last(self) -> VehicleCommand:
        """The command that the car obeyed last."""
        return self._last

    def obey(self, command: VehicleCommand, tick: int, by_hand: bool = False) -> bool:
        """Take a command, clamped to its range; returns whether it had to be. Raises ValueError for NaN and infinities."""
        command, clamped = command.clamped()
        self._orders[by_hand] = command, tick
        return clamped

    def obey_ackermann(self, target: AckermannTarget, tick: int) -> bool:
        """Take a speed and a wheel angle from the software; returns whether they had to be limited. Raises ValueError for NaN."""
        target, limited = self._ackermann.limited(target)
        self._orders[False] = target, tick
        return limited

    def take_over(self, by_hand: bool, tick: int) -> None:
        """A person takes the car over, or gives it back. The car coasts until the person's first command."""
        if by_hand and not self.by_hand:
            self._orders[True] = VehicleCommand(), tick
        self.by_hand = by_hand

    def silent(self, tick: int) -> bool:
        """Whether a driver who has commanded before has been without a new command for too long."""
        order = self._orders[self.by_hand]
        return (
            order is not None
            and self._patience_ticks > 0
            and tick - order[1] > self._patience_ticks
        )

    def command(self, tick: int, state: VehicleState, tick_s: float) -> VehicleCommand:
        """The command that the car obeys in this tick; to be asked once a tick."""
        order = self._orders[self.by_hand]
        order = self._latency.put(order[0] if order else VehicleCommand())
        if not isinstance(order, AckermannTarget) and self._ackermann is not None:
            self._ackermann.reset()
        if self.silent(tick):
            # The wheel stays where it is: in a bend, straight on would be off the road.
            self._last = VehicleCommand(steer=self._last.steer, brake=1.0)
        elif isinstance(order, AckermannTarget):
            self._last = self._ackermann.command(
                order, state.speed_mps, state.wheel_angle_rad, tick_s
            )
        else:
            self._last = order or VehicleCommand()
        return self._last

    def memory(self) -> dict:
        """Who drives and what was ordered, as plain data."""
        return {
            "by_hand": self.by_hand,
            "last": _plain(self._last),
            "latency": [_plain(order) for order in self._latency.items],
            "orders": [
                order and [_plain(order[0]), order[1]]
                for order in (self._orders[False], self._orders[True])
            ],
            "ackermann": self._ackermann.memory() if self._ackermann is not None else None,
        }

    def recall(self, memory: dict) -> None:
        """Go on as `memory` said."""
        self.by_hand = memory["by_hand"]
        self._last = _order(memory["last"])
        self._latency.fill(map(_order, memory["latency"]))
        self._orders = {
            by_hand: entry and (_order(entry[0]), entry[1])
            for by_hand, entry in zip((False, True), memory["orders"])
        }
        if self._ackermann is not None:
            self._ackermann.recall(memory["ackermann"])

    def reset(self) -> None:
        """Forget every order, as for a car that has just been put down; who drives stays as it is."""
        self._orders = {False: None, True: None}
        self._latency.clear()
        self._last = VehicleCommand()


def _plain(order) -> list:
    return [isinstance(order, AckermannTarget), *vars(order).values()]


def _order(plain: list):
    return (AckermannTarget if plain[0] else VehicleCommand)(*plain[1:])
