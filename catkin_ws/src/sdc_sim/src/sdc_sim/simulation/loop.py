"""The loop of a drive in one process: the world steps, the car answers, the evaluation watches."""

from __future__ import annotations

from typing import Any, Callable, Protocol

from sdc_common.driving import Command, Observation, Path
from sdc_sim.simulation.simulation import Simulation
from sdc_sim.simulation.snapshot import Snapshot


class Driver(Protocol):
    """The software of a car."""

    @property
    def path(self) -> Path | None:
        """The path that it followed in the last step, None if it had none."""

    @property
    def reason(self) -> str:
        """What limited its speed in the last step, "" if unknown."""

    def step(self, observation: Observation) -> Command | None:
        """Return the command that answers an observation; None leaves the last one in force."""
        raise NotImplementedError


class Evaluation(Protocol):
    """Watches a drive, and ends it."""

    def add(self, snapshot: Snapshot, command: Command | None, car: Driver) -> bool:
        """Add a tick of the world and the car's answer; return whether the drive is over."""
        raise NotImplementedError


def drive(
    world: Simulation,
    car: Driver,
    evaluation: Evaluation,
    longest_s: float | None = None,
    observe: Callable[[Snapshot], Any] | None = None,
) -> None:
    """Drive tick by tick until the evaluation ends the drive.

    Args:
        world: the simulation at its start
        car: the software of the car
        evaluation: watches the drive
        longest_s: simulated time after which to stop, None for no limit [s]
        observe: called with the true state in each tick
    """
    observation = world.observation
    while True:
        snapshot = world.snapshot
        if observe is not None:
            observe(snapshot)
        command = car.step(observation)
        over = evaluation.add(snapshot, command, car)
        if over or (longest_s is not None and world.elapsed_s >= longest_s):
            return
        observation = world.step(command)
