# Nothing listens beyond this machine unless the user says how ROS is to be reached: by ROS_IP, ROS_HOSTNAME or a master elsewhere.
case "${ROS_MASTER_URI:-http://localhost:11311}" in
    http://localhost:* | http://127.0.0.1:*)
        [ -n "${ROS_IP:-}${ROS_HOSTNAME:-}" ] || export ROS_IP=127.0.0.1 ;;
esac
