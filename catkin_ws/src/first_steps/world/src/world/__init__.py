"""The world of the red square: field, waypoints, car, sensor, laps. Nothing here knows of ROS or of a clock."""
