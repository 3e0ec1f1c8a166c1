"""The window on the field. view, trail and scene know nothing of Qt; nothing here knows of ROS."""
