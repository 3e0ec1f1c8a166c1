#!/bin/sh
# Runs a node of the world in the environment of the workspace that this file lies in. Whoever starts it may have another sdc_package, one that
# is still being written: the car may be unfinished, but not the world.
# Usage: own_environment.sh COMMAND [ARGUMENT ...]
folder=$(cd "$(dirname "$0")" && pwd)
while [ "$folder" != / ]; do
    folder=$(dirname "$folder")
    for workspace in "$folder/devel" "$folder"; do
        [ -f "$workspace/env.sh" ] && [ -f "$workspace/.catkin" ] || continue
        [ "${CMAKE_PREFIX_PATH%%:*}" != "$workspace" ] || exec "$@"
        # The workspace may have an opinion on where the master is: the caller's counts.
        exec sh "$workspace/env.sh" env "ROS_MASTER_URI=$ROS_MASTER_URI" "$@"
    done
done
exec "$@"
