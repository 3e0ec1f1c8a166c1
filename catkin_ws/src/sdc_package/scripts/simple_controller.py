#!/usr/bin/env python3
"""Controller: answer each pair of odometry and local path with throttle, brake and steer."""

import rospy
from nav_msgs.msg import Odometry
from sdc_common.driving import Command
from sdc_common.ros.conversion import stamp_of
from sdc_common.ros.node import LoopPublisher, every, offer_reload, parameter, refuse
from sdc_common.ros.node import watch_connections
from sdc_common.ros.refusal import refusing
from sdc_common.ros.speed_reason_publisher import SpeedReasonPublisher
from sdc_common.validation import check_between
from sdc_package.controller import Controller
from sdc_package.input_pairing import InputPairing
from sdc_package.steering.axles import Axles
from sdc_package.steering.loader import load_steering, section_of

# TODO 1.1: the message that drives the car
from sdc_package.msg import CarlaVehicleControl
# --------------------------------------------------------------------------------

# TODO 2.1: the message of the path ahead
from sdc_package.msg import LocalPath
# --------------------------------------------------------------------------------


class SimpleController:
    def __init__(self):
        # TODO 1.2 (given): register this program with ROS as the node "simple_controller"
        rospy.init_node("simple_controller")
        # ------------------------------------------------------------------------
        self.basic_control = parameter("basic_control")
        self.basic_throttle = parameter("basic_throttle")
        self.basic_steer = parameter("basic_steer")
        try:
            check_between(0.0, 1.0, basic_throttle=self.basic_throttle)
            check_between(-1.0, 1.0, basic_steer=self.basic_steer)
            self.axles = Axles(**parameter("axles"))
            self.controller = Controller(parameter, self.steering(parameter("steering_method")))
            patience_s, path_needed = parameter("patience_s"), not self.basic_control
            self.inputs = InputPairing(self.answer, self.stop, patience_s, path_needed)
        except (TypeError, ValueError) as error:
            refuse(f"config/simple_controller.yaml: {error}")
        offer_reload(self.reload)
        self.reasons = SpeedReasonPublisher()

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

    def steering(self, method):
        """Return a steering method with the parameters of its section."""
        section = rospy.get_param("~" + section_of(method), None)
        return load_steering(method, section, self.axles)

    def reload(self):
        """Steer with the parameters as they are now, from the next odometry on."""
        self.controller.steering = self.steering(rospy.get_param("~steering_method", ""))
        rospy.loginfo("simple_controller: the steering has new parameters")

    def on_odometry(self, odometry):
        with refusing("/carla/ego_vehicle/odometry"):
            self.inputs.add_odometry(odometry)

    def on_path(self, path):
        with refusing("/planner/local_waypoints"):
            # TODO 2.3: hand the points on, as a list of (x, y, v) (until then: return)
            self.inputs.add_path([(point.x, point.y, point.v) for point in path.waypoints])
            # --------------------------------------------------------------------

    def answer(self, observation, path):
        """Answer one odometry: `observation` is how the car moves, `path` the path ahead of it."""
        if self.basic_control:
            self.controller.steer = self.basic_steer
            command = Command(self.basic_throttle, self.basic_steer, stamp_ns=observation.stamp_ns)
        else:
            command = self.controller.command(observation, path)
        self.send(command)

    def stop(self, missing, observation, path):
        """Brake along the last path while an input is missing; without one, hold the steer."""
        stamp = rospy.Time.now() if observation is None else stamp_of(observation)
        self.reasons.timed_out(missing, stamp)
        self.send(self.controller.stop(observation, path if missing == "path" else None))

    def send(self, command):
        if command is not None:
            self.publish(stamp_of(command), command.throttle, command.steer, command.brake)

    def publish(self, stamp, throttle, steer, brake):
        # TODO 1.5: publish a command that carries this stamp (until then: pass)
        command = CarlaVehicleControl(throttle=throttle, steer=steer, brake=brake)
        command.header.stamp = stamp
        self.publisher.publish(command)
        # ------------------------------------------------------------------------

    def run(self):
        watch_connections()
        every(0.1, lambda: self.inputs.check(rospy.Time.now().to_nsec()))
        rospy.spin()


if __name__ == "__main__":
    SimpleController().run()
