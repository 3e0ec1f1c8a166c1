"""The algorithm that steers the red square. Nothing here knows of ROS or of a clock."""
