"""The window on the field, without ROS; the settings are also without Qt."""
