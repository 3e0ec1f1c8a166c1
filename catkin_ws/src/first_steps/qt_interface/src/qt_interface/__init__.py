"""The window on the field, without ROS; scene, settings and view are also without Qt."""
