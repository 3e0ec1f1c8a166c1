"""The window on the field, without ROS; view, trail and scene are also without Qt."""
