#!/usr/bin/env python3
"""Controller: answers each pair of odometry and local path with throttle, brake and steer."""

import threading

import rospy
from nav_msgs.msg import Odometry

# TODO 1.1: the message that a car is driven with
from sdc_package.msg import CarlaVehicleControl

# --------------------------------------------------------------------------------
# TODO 2.1: the message of the road ahead
from sdc_package.msg import LocalPath
# --------------------------------------------------------------------------------

from sdc_common.geometry.angles import wrap_angle
from sdc_package.steering.axles import Axles
from sdc_package.actuation import PedalMap, SteeringMap
from sdc_common.validation import check_between, check_positive
from sdc_package.local_path import ReferencePath as Road
from sdc_common.ros.node import LoopPublisher, every, parameter, refuse
from sdc_package.odometry import pose_and_speed
from sdc_package.pid import PidGains
from sdc_package.speed_control import SpeedControl, SpeedControlLimits
from sdc_package.steering.method import load_steering, section_of
from sdc_common.ros.connection_watchdog import watch_connections

LONGEST_STEP_S = 0.2
LOOK_EVERY_S = 0.1


class SimpleController:
    def __init__(self):
        # TODO 1.2: register this program with ROS as the node "simple_controller"
        rospy.init_node("simple_controller")
        # ------------------------------------------------------------------------
        self.basic_control = parameter("basic_control")
        self.basic_throttle = parameter("basic_throttle")
        self.basic_steer = parameter("basic_steer")
        self.patience_s = parameter("patience_s")
        self.stop_brake = parameter("stop_brake")
        try:
            check_between(0.0, 1.0, basic_throttle=self.basic_throttle, stop_brake=self.stop_brake)
            check_between(-1.0, 1.0, basic_steer=self.basic_steer)
            check_positive(patience_s=self.patience_s)
            method = parameter("steering_method")
            self.steering = load_steering(
                method, rospy.get_param("~" + section_of(method), None), Axles(**parameter("axles"))
            )
            self.speed_control = SpeedControl(
                PidGains(**parameter("pid")), SpeedControlLimits(**parameter("limits"))
            )
            self.steering_map = SteeringMap(**parameter("steering"))
            self.pedal_map = PedalMap(**parameter("pedals"))
        except (TypeError, ValueError) as error:
            refuse(f"{error}; mend it in config/simple_controller.yaml")

        self.lock = threading.Lock()
        self.road = Road()
        self.odometry = None
        self.last_pose = None
        self.last_command = None
        self.odometry_waits = False
        self.path_waits = False
        self.path_heard_at = rospy.Time(0)

        # TODO 1.3: a publisher of commands to the car
        self.publisher = LoopPublisher(
            "/carla/ego_vehicle/vehicle_control_cmd", CarlaVehicleControl
        )
        # ------------------------------------------------------------------------
        # TODO 1.4: listen to where the car is and how fast: on_odometry
        rospy.Subscriber(
            "/carla/ego_vehicle/odometry",
            Odometry,
            self.on_odometry,
            queue_size=1,
            tcp_nodelay=True,
        )
        # ------------------------------------------------------------------------
        # TODO 2.2: listen to the road ahead: on_path
        rospy.Subscriber(
            "/planner/local_waypoints", LocalPath, self.on_path, queue_size=1, tcp_nodelay=True
        )
        # ------------------------------------------------------------------------
        every(LOOK_EVERY_S, self.look)

    def on_odometry(self, odometry):
        with self.lock:
            if self.odometry is not None and odometry.header.stamp == self.odometry.header.stamp:
                self.repeat()
                return
            try:
                pose_and_speed(odometry)
            except ValueError as error:
                rospy.logwarn_throttle(
                    1.0, f"simple_controller: refused /carla/ego_vehicle/odometry: {error}"
                )
                return
            self.odometry = odometry
            self.odometry_waits = True
            if self.basic_control:
                self.odometry_waits = False
                self.publish(self.basic_throttle, self.basic_steer, 0.0)
            elif self.path_waits:
                self.answer()
            elif self.path_heard_at and self.silent_topic(odometry.header.stamp):
                self.stop("path")

    def on_path(self, path):
        with self.lock:
            try:
                # TODO 2.3: keep the path, as a list of (x, y, v) (until then: return)
                self.road.update([(point.x, point.y, point.v) for point in path.waypoints])
                # ----------------------------------------------------------------
            except ValueError as error:
                rospy.logwarn_throttle(
                    1.0, f"simple_controller: refused a path on /planner/local_waypoints: {error}"
                )
                return
            self.path_waits = True
            if self.odometry is not None:
                self.path_heard_at = self.odometry.header.stamp
            if self.odometry_waits and not self.basic_control:
                self.answer()

    def answer(self):
        """One pair is complete: drive."""
        x, y, yaw, speed = pose_and_speed(self.odometry)
        stamp_s = self.odometry.header.stamp.to_sec()
        last_stamp_s, last_yaw = self.last_pose or (stamp_s, yaw)
        step_s = min(max(stamp_s - last_stamp_s, 0.0), LONGEST_STEP_S)
        yaw_rate = wrap_angle(yaw - last_yaw) / step_s if step_s > 0.0 else 0.0
        self.last_pose = stamp_s, yaw

        self.odometry_waits = self.path_waits = False
        # TODO 2.8: what the road asks for here: an acceleration, and an angle of the front wheels (until then: return)
        target = self.road.nearest(x, y, self.speed_control.preview_m(speed))
        acceleration = self.speed_control.acceleration(
            target.speed_mps, target.acceleration_mps2, speed, step_s
        )
        wheel_angle = self.steering.wheel_angle(self.road, x, y, yaw, speed, yaw_rate)
        # ------------------------------------------------------------------------
        # TODO 2.9: the pedals for this acceleration, the steer command for this angle: publish them
        throttle, brake = self.pedal_map.pedals(acceleration)
        steer, _ = self.steering_map.command(wheel_angle, speed)
        self.publish(throttle, steer, brake)
        # ------------------------------------------------------------------------

    def repeat(self):
        """A simulator that has not heard the answer to its first odometry repeats it: so does the answer, and a path that came
        twice while this node was connecting belongs to no other odometry."""
        if not self.odometry_waits:
            self.path_waits = False
            self.publisher.publish(self.last_command)

    def look(self):
        """Brake when the world or the planner has fallen silent."""
        with self.lock:
            silent = self.silent_topic(rospy.Time.now())
            if silent is not None:
                self.stop(silent)

    def stop(self, silent):
        """Brake for want of `silent`, along the last known road, or with the wheel as it was. The command bears no stamp: it answers no
        odometry, and a simulator in lockstep goes on waiting for the node that will."""
        rospy.logwarn_throttle(
            5.0, f"simple_controller: no {silent} for {self.patience_s:g} s, braking"
        )
        self.speed_control.reset()
        steer = self.last_command.steer if self.last_command is not None else 0.0
        if silent == "path" and self.road.line is not None:
            x, y, yaw, speed = pose_and_speed(self.odometry)
            steer, _ = self.steering_map.command(
                self.steering.wheel_angle(self.road, x, y, yaw, speed), speed
            )
        self.publisher.publish(CarlaVehicleControl(steer=steer, brake=self.stop_brake))

    def silent_topic(self, now):
        """What has not been heard for too long. A path's age is reckoned in odometry stamps: the clock comes on a connection of
        its own and may be seconds ahead or behind when time runs fast."""
        heard = self.odometry.header.stamp if self.odometry is not None else rospy.Time(0)
        if (now - heard).to_sec() > self.patience_s:
            return "odometry"
        if (heard - self.path_heard_at).to_sec() > self.patience_s and not self.basic_control:
            return "path"
        return None

    def publish(self, throttle, steer, brake):
        # TODO 1.5: fill in a command, give it the stamp of the odometry that it answers, remember it and publish it (until then: pass)
        command = CarlaVehicleControl(throttle=throttle, steer=steer, brake=brake)
        if self.odometry is not None:
            command.header.stamp = self.odometry.header.stamp
        self.last_command = command
        self.publisher.publish(command)
        # ------------------------------------------------------------------------

    def run(self):
        watch_connections()
        rospy.spin()


if __name__ == "__main__":
    SimpleController().run()
