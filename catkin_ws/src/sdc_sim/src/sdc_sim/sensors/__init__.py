"""Sensors of the vehicle and their errors, without ROS."""
