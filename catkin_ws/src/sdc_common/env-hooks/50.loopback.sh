# Nothing listens beyond this machine, unless the user sets ROS_IP, ROS_HOSTNAME or a master on another machine.
case "${ROS_MASTER_URI:-http://localhost:11311}" in
    http://localhost:* | http://127.0.0.1:*)
        [ -n "${ROS_IP:-}${ROS_HOSTNAME:-}" ] || export ROS_IP=127.0.0.1 ;;
esac
