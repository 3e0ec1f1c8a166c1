"""A world for a self-driving car: physics, camera, time, and the referee that measures a drive."""
