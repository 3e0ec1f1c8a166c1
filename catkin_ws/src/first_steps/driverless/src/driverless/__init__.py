"""The algorithm that steers the red square, without ROS and without a clock."""
