"""The world at one tick: the car, the command that it obeys, and simulated time."""
from __future__ import annotations

from sdc_sim.vehicle import Vehicle, VehicleCommand

_NANOSECONDS = 1_000_000_000


class World:
    """A car that obeys the last command, tick after tick.

    command_patience_s is how long a command stays in force without a new one before the car brakes by itself; 0 means for ever.
    Time is counted in whole ticks, so that it neither drifts nor depends on a clock.
    """

    EMERGENCY = VehicleCommand(brake=1.0)

    def __init__(self, vehicle: Vehicle, tick_s: float, command_patience_s: float):
        if not tick_s > 0.0:
            raise ValueError(f"tick_s must be positive, got {tick_s}")
        if not command_patience_s >= 0.0:
            raise ValueError(f"command_patience_s must not be negative, got {command_patience_s}")
        self.vehicle = vehicle
        self.tick_s = tick_s
        self.tick = 1
        self._tick_ns = round(tick_s * _NANOSECONDS)
        self._patience_ticks = round(command_patience_s / tick_s)
        self._command = VehicleCommand()
        self._commanded_at = None

    @property
    def stamp(self):
        """Simulated time as (seconds, nanoseconds); the first tick is not zero, which ROS takes for 'no time yet'."""
        return divmod(self.tick * self._tick_ns, _NANOSECONDS)

    @property
    def silent(self) -> bool:
        """Whether a car that was commanded before has been without a new command for too long."""
        return (self._commanded_at is not None and self._patience_ticks > 0
                and self.tick - self._commanded_at > self._patience_ticks)

    def obey(self, command: VehicleCommand) -> bool:
        """Take a command, clamped to its range; returns whether it had to be clamped. Raises ValueError for NaN and infinities."""
        self._command, clamped = command.clamped()
        self._commanded_at = self.tick
        return clamped

    def advance(self) -> None:
        """One tick of simulated time."""
        self.vehicle.step(self.EMERGENCY if self.silent else self._command, self.tick_s)
        self.tick += 1
