"""Physics of the simulation: vehicle, Ackermann control, collisions, obstacles, traffic lights."""
