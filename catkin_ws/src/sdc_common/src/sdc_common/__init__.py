"""Path geometry, waypoint files, speed profiles and ROS helpers for the car and the world."""
