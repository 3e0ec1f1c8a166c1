"""Selection of the command that the vehicle executes, and of the observation that it answers."""

from __future__ import annotations

from typing import Tuple, Union

from sdc_common.driving import Command
from sdc_sim.physics.ackermann import AckermannControl, AckermannTarget
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.sensors.errors import DelayLine

AnyCommand = Union[Command, AckermannTarget]
_Entry = Tuple[AnyCommand, int]  # a command and the tick at which it was accepted


class CommandMux:
    """Stores the latest software and manual commands and selects one of them in each tick.

    The manual command applies while `manual_override` is set. The latest software command is kept
    and applies when the override ends.

    Args:
        timeout_ticks: time without a new command after which the vehicle brakes; 0 is never
        latency: delay between a command and its execution; the braking after a timeout has none
        ackermann: converts Ackermann targets to pedals and steering
    """

    def __init__(self, timeout_ticks: int, latency: DelayLine, ackermann: AckermannControl):
        self.manual_override = False
        self.executed = Command()
        self._timeout_ticks = timeout_ticks
        self._latency = latency
        self.ackermann = ackermann
        self._entries: dict[bool, _Entry] = {}  # by whether they are manual

    def accept(self, command: AnyCommand, tick: int, manual: bool = False) -> bool:
        """Store a command, limited to its range, from this tick on.

        Returns:
            whether it was outside its range

        Raises:
            ValueError: a value is NaN or infinite
        """
        limited: AnyCommand
        if isinstance(command, Command):
            limited, outside = command.clamped()
        else:
            limited, outside = self.ackermann.limited(command)
        self._entries[manual] = limited, tick
        return outside

    def set_manual_override(self, enabled: bool, tick: int) -> None:
        """Start or end manual control. The vehicle coasts until the first manual command."""
        if enabled and not self.manual_override:
            self._entries[True] = Command(), tick
        self.manual_override = enabled

    @property
    def ackermann_target(self) -> AckermannTarget | None:
        """The active command if it is an Ackermann target."""
        entry = self._active
        return entry[0] if entry and isinstance(entry[0], AckermannTarget) else None

    def timed_out(self, tick: int) -> bool:
        """Return whether the latest command is too old. Before the first one nothing times out."""
        entry = self._active
        return entry is not None and 0 < self._timeout_ticks < tick - entry[1]

    @property
    def _active(self) -> _Entry | None:
        return self._entries.get(self.manual_override)

    def select(self, tick: int, state: VehicleState, tick_s: float) -> Command:
        """Return the command to execute in this tick; call it once a tick."""
        entry = self._active
        command = self._latency.put(entry[0] if entry else Command())
        if not isinstance(command, AckermannTarget):
            self.ackermann.reset()
        if self.timed_out(tick):
            # The steering keeps its position: in a bend, straight wheels leave the road.
            self.executed = Command(steer=self.executed.steer, brake=1.0)
        elif isinstance(command, AckermannTarget):
            self.executed = self.ackermann.command(
                command, state.speed_mps, state.wheel_angle_rad, tick_s
            )
        else:
            self.executed = command or Command()
        return self.executed

    def reset(self) -> None:
        """Forget all commands; the manual override stays."""
        self._entries.clear()
        self._latency.clear()
        self.executed = Command()


class CommandArbiter:
    """Accepts commands of one publisher at a time: a car that obeys two jerks between them.

    The first publisher keeps control until it has sent no command for timeout_ticks. Then the next
    one that sends a command gets control.
    """

    def __init__(self, timeout_ticks: int):
        self._timeout_ticks = timeout_ticks
        self._last_tick = 0
        self.active: str | None = None

    def in_control(self, tick: int) -> bool:
        """Return whether a publisher has control in this tick."""
        return self.active is not None and tick - self._last_tick <= self._timeout_ticks

    def admits(self, name: str, tick: int) -> bool:
        """Return whether to accept a command that this publisher sends in this tick."""
        if self.active != name and self.in_control(tick):
            return False
        self.active = name
        self._last_tick = tick
        return True

    def release(self) -> None:
        """Accept the next command of any publisher."""
        self.active = None


class AnswerTracker:
    """Decides whether the last observation has an answer.

    A command with a stamp answers the observation with this stamp. A command without one, whose
    stamp is 0, answers the last observation. When a tick has ended without an answer although a
    command with another stamp has arrived, as one of the wall clock, stamps are ignored from then
    on.
    """

    def __init__(self) -> None:
        self.answered = False  # whether a command has answered the last observation
        self.by_stamp = False  # whether the last command had a stamp that is not ignored
        self._ignores_stamps = False
        self._other_stamp = False
        self._last_answered_ns = 0

    def expect(self) -> None:
        """Expect the answer to a new observation."""
        self.answered = self._other_stamp = False

    def is_repeated(self, stamp_ns: int, observed_ns: int) -> bool:
        """Return whether a command with this stamp answers an observation that has an answer."""
        repeated = not self._ignores_stamps and 0 < stamp_ns <= self._last_answered_ns
        if repeated and stamp_ns < observed_ns:
            self._other_stamp = True
        return repeated

    def record(self, stamp_ns: int, observed_ns: int) -> None:
        """Record a command with this stamp while the observation `observed_ns` is the last one."""
        self.by_stamp = stamp_ns != 0 and not self._ignores_stamps
        if not self.by_stamp:
            self.answered = True
        elif stamp_ns == observed_ns:
            self.answered, self._last_answered_ns = True, stamp_ns
        else:
            self._other_stamp = True

    def give_up(self) -> None:
        """Record that the next tick starts without an answer to the last observation."""
        if self._other_stamp:
            self._ignores_stamps, self.by_stamp = True, False
