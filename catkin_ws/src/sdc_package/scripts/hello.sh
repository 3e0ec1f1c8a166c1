#!/usr/bin/env bash
# The first node of the workshop: any program can be one.
echo "Hello! This is $(basename "$0"), started by ROS. The car is ready when you are."
