"""The simulation tick by tick, without ROS: Simulation.reset() and Simulation.step(command)."""

from sdc_sim.physics.vehicle import VehicleCommand
from sdc_sim.simulation.simulation import Observation, Simulation

__all__ = ["Observation", "Simulation", "VehicleCommand"]
