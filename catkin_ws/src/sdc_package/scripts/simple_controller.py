#!/usr/bin/env python3
"""Controller: answer each pair of odometry and local path with throttle, brake and steer."""

import rospy
from nav_msgs.msg import Odometry
from sdc_common.ros.connection_watchdog import watch_connections
from sdc_common.ros.node import LoopPublisher, every, parameter, refuse
from sdc_common.ros.refusal import refusing
from sdc_common.ros.speed_reason_publisher import SpeedReasonPublisher
from sdc_common.validation import check_between
from sdc_package.actuation import PedalMap, SteeringMap
from sdc_package.input_pairing import InputPairing
from sdc_package.live_steering import LiveSteering
from sdc_package.pid import PidGains
from sdc_package.speed_control import SpeedControl, SpeedControlLimits
from sdc_package.steering.axles import Axles
from sdc_package.watchdog import InputWatchdog

# TODO 1.1: the message that drives the car
from sdc_package.msg import CarlaVehicleControl
# --------------------------------------------------------------------------------

# TODO 2.1: the message of the path ahead
from sdc_package.msg import LocalPath
# --------------------------------------------------------------------------------


class SimpleController:
    def __init__(self):
        # TODO 1.2: register this program with ROS as the node "simple_controller"
        rospy.init_node("simple_controller")
        # ------------------------------------------------------------------------
        self.basic_control = parameter("basic_control")
        self.basic_throttle = parameter("basic_throttle")
        self.basic_steer = parameter("basic_steer")
        self.stop_brake = parameter("stop_brake")
        try:
            check_between(0.0, 1.0, basic_throttle=self.basic_throttle, stop_brake=self.stop_brake)
            check_between(-1.0, 1.0, basic_steer=self.basic_steer)
            self.steering = LiveSteering(parameter("steering_method"), Axles(**parameter("axles")))
            limits = SpeedControlLimits(**parameter("limits"))
            self.speed_control = SpeedControl(PidGains(**parameter("pid")), limits)
            self.steering_map = SteeringMap(**parameter("steering"))
            self.pedal_map = PedalMap(**parameter("pedals"))
            watchdog = InputWatchdog(parameter("patience_s"))
        except (TypeError, ValueError) as error:
            refuse(f"config/simple_controller.yaml: {error}")
        self.inputs = InputPairing(self.answer, self.stop, watchdog, not self.basic_control)
        self.reasons = SpeedReasonPublisher()
        self.steer = 0.0

        # TODO 1.3: a publisher of commands to the car
        topic = "/carla/ego_vehicle/vehicle_control_cmd"
        self.publisher = LoopPublisher(topic, CarlaVehicleControl, latch=True)
        # ------------------------------------------------------------------------
        # TODO 1.4: subscribe to the odometry: on_odometry receives it
        topic = "/carla/ego_vehicle/odometry"
        rospy.Subscriber(topic, Odometry, self.on_odometry, queue_size=1, tcp_nodelay=True)
        # ------------------------------------------------------------------------
        # TODO 2.2: subscribe to the path ahead: on_path receives it
        topic = "/planner/local_waypoints"
        rospy.Subscriber(topic, LocalPath, self.on_path, queue_size=1, tcp_nodelay=True)
        # ------------------------------------------------------------------------

    def on_odometry(self, odometry):
        with refusing("/carla/ego_vehicle/odometry"):
            self.inputs.add_odometry(odometry)

    def on_path(self, path):
        with refusing("/planner/local_waypoints"):
            # TODO 2.3: hand the points on, as a list of (x, y, v) (until then: return)
            self.inputs.add_path([(point.x, point.y, point.v) for point in path.waypoints])
            # --------------------------------------------------------------------

    def answer(self, motion, path):
        """Answer one odometry: `motion` is how the car moves, `path` is the path ahead of it."""
        if self.basic_control:
            self.steer = self.basic_steer
            self.publish(motion.stamp, self.basic_throttle, self.steer, 0.0)
            return
        x, y, yaw, speed = motion.x_m, motion.y_m, motion.yaw_rad, motion.speed_mps
        target = path.nearest(x, y, self.speed_control.preview_m(speed))
        acceleration = self.speed_control.acceleration(
            target.speed_mps, target.acceleration_mps2, speed, motion.step_s
        )
        wheel_angle = self.steering.wheel_angle(path, x, y, yaw, speed, motion.yaw_rate_radps)
        throttle, brake = self.pedal_map.pedals(acceleration)
        self.steer, _ = self.steering_map.command(wheel_angle, speed)
        self.publish(motion.stamp, throttle, self.steer, brake)

    def stop(self, missing, motion, path):
        """Brake along the last path while an input is missing; without one, hold the steer."""
        self.reasons.timed_out(missing, motion.stamp if motion else rospy.Time.now())
        self.speed_control.reset()
        if missing == "path" and path is not None:
            wheel_angle = self.steering.wheel_angle(path, *motion[1:5])
            self.steer, _ = self.steering_map.command(wheel_angle, motion.speed_mps)
        self.publish(rospy.Time(), 0.0, self.steer, self.stop_brake)

    def publish(self, stamp, throttle, steer, brake):
        # TODO 1.5: publish a command that carries this stamp (until then: pass)
        command = CarlaVehicleControl(throttle=throttle, steer=steer, brake=brake)
        command.header.stamp = stamp
        self.publisher.publish(command)
        # ------------------------------------------------------------------------

    def run(self):
        watch_connections()
        every(0.1, lambda: self.inputs.check(rospy.Time.now()))
        rospy.spin()


if __name__ == "__main__":
    SimpleController().run()
