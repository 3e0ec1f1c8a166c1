"""The software of a self-driving car: the thinking behind the nodes, free of ROS."""
