"""Studies of the car and the world: steering methods, benchmarks and endurance."""
