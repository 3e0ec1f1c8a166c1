"""What nodes need from ROS and the operating system in addition to rospy."""
