"""The world as ROS nodes: messages, services and the start of a drive."""
