"""The simulation tick by tick, without ROS: `observation = Simulation.step(command)`."""

from sdc_common.driving import Command, Observation
from sdc_sim.simulation.simulation import Simulation

__all__ = ["Command", "Observation", "Simulation"]
