"""The simulation tick by tick, without ROS: Simulation.reset() and Simulation.step(command)."""
