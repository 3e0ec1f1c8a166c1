"""Functions of nodes in addition to rospy: messages, parameters, workspaces and masters."""
