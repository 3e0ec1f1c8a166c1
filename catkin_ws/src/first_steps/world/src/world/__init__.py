"""The world of the red square: field, waypoints, car, sensor and laps, without ROS or a clock."""
