#!/usr/bin/env python3
"""The world: a car that obeys the control command, on a road made from the route, seen by a camera."""
import os
import threading
import time

import cv2
import rospy
import tf2_ros
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sdc_package.msg import CarlaVehicleControl
from sensor_msgs.msg import CameraInfo, Image
from tf2_msgs.msg import TFMessage

from sdc_package.node import loop_publisher, parameter, refuse
from sdc_package.route import Route
from sdc_package.waypoints import WaypointError, load_waypoints
from sdc_sim.background import Background
from sdc_sim.messages import camera_info_message, camera_transform, image_message, odometry_message, vehicle_transform
from sdc_sim.vehicle import Vehicle, VehicleCommand, VehicleError, load_vehicle
from sdc_sim.world import World

EGO = "/carla/ego_vehicle"
UNSTAMPED = (0, 0)


class Sim:
    def __init__(self):
        rospy.init_node("sim")
        cv2.setNumThreads(1)
        self.sync = parameter("sync")
        self.patience_s = parameter("patience_s")
        self.unstamped_patience_s = parameter("unstamped_patience_s")
        self.start_patience_s = parameter("start_patience_s")
        self.wait_for_nodes = set(parameter("wait_for_nodes"))
        try:
            route_m = load_waypoints(parameter("waypoints_path"))
            vehicle = Vehicle(load_vehicle(os.path.join(parameter("vehicles_folder"), parameter("vehicle") + ".yaml")))
            self.world = World(vehicle, parameter("tick_s"), parameter("command_patience_s"))
        except (WaypointError, VehicleError) as error:
            refuse(error)
        except (TypeError, ValueError) as error:
            refuse(f"{error}; mend it in config/sim.yaml")
        start = Route(route_m[:2])
        vehicle.reset(*start.points[0].tolist(), float(start.heading[0]))

        self.lock = threading.Lock()
        self.started = False
        self.stamps_seen = False
        self.obeyed_stamp = UNSTAMPED

        self.clock_publisher = loop_publisher("/clock", Clock)
        self.tf_publisher = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self.odometry_publisher = loop_publisher(EGO + "/odometry", Odometry)
        self.images = None
        if parameter("camera"):
            self.open_camera(route_m)

        rospy.Subscriber(EGO + "/vehicle_control_cmd", CarlaVehicleControl, self.on_command, queue_size=10, tcp_nodelay=True)

    def open_camera(self, route_m):
        from sdc_sim.camera import CameraModel, Renderer  # a world without a picture starts faster without them
        from sdc_sim.road import Road
        model = CameraModel()
        self.renderer = Renderer(Road(route_m), model)
        self.camera_info = camera_info_message(model)
        self.image_publisher = rospy.Publisher(EGO + "/camera/rgb/front/image_color", Image, queue_size=2)
        self.camera_info_publisher = rospy.Publisher(EGO + "/camera/rgb/front/camera_info", CameraInfo, queue_size=2)
        self.static_tf = tf2_ros.StaticTransformBroadcaster()
        self.static_tf.sendTransform(camera_transform(model))
        self.images = Background(self.publish_image)

    def on_command(self, message):
        command = VehicleCommand(message.throttle, message.steer, message.brake, message.hand_brake, message.reverse)
        stamp = (message.header.stamp.secs, message.header.stamp.nsecs)
        with self.lock:
            if self.sync and stamp != UNSTAMPED:
                if stamp <= self.obeyed_stamp:
                    return  # an answer that was sent twice
                self.obeyed_stamp = stamp
            try:
                clamped = self.world.obey(command)
            except ValueError as error:
                rospy.logwarn_throttle(1.0, f"sim: refused a command on {EGO}/vehicle_control_cmd: {error}")
                return
            if clamped:
                rospy.logwarn_throttle(1.0, f"sim: clamped a command on {EGO}/vehicle_control_cmd to its range")
            self.stamps_seen = stamp != UNSTAMPED
            if self.sync and self.started and stamp == self.world.stamp:
                self.advance()

    def advance(self):
        self.world.advance()
        self.publish()
        if self.world.silent:
            rospy.logwarn_throttle(5.0, f"sim: no command on {EGO}/vehicle_control_cmd, braking")

    def publish(self):
        stamp = rospy.Time(*self.world.stamp)
        odometry = odometry_message(self.world.vehicle.state, stamp)
        self.clock_publisher.publish(stamp)
        self.odometry_publisher.publish(odometry)
        self.tf_publisher.publish([vehicle_transform(odometry)])
        if self.images:
            state = self.world.vehicle.state
            frame = (stamp, state.x_m, state.y_m, state.yaw_rad)
            self.images.put(frame) if self.sync else self.images.offer(frame)

    def publish_image(self, frame):
        stamp, x, y, yaw = frame
        picture = self.renderer.render(x, y, yaw)
        self.image_publisher.publish(image_message(picture, stamp))
        self.camera_info.header.stamp = stamp
        self.camera_info_publisher.publish(self.camera_info)

    def run_in_real_time(self):
        due = time.monotonic()
        while not rospy.is_shutdown():
            with self.lock:
                self.advance()
            due += self.world.tick_s
            late = time.monotonic() - due
            if late < 0.0:
                time.sleep(-late)
            else:
                due += late  # an overloaded machine slows the world down; time lost is not made up in a rush

    def run_in_lockstep(self):
        """on_command advances the world; here stands only what happens when no answer comes."""
        self.wait_for_stack()
        while not rospy.is_shutdown():
            tick = self.world.tick
            time.sleep(self.patience_s if self.stamps_seen else self.unstamped_patience_s)
            with self.lock:
                if self.world.tick == tick:
                    rospy.logwarn_throttle(5.0, "sim: no command carries the stamp of the last odometry; going on without")
                    self.advance()

    def wait_for_stack(self):
        """Repeat the first tick until a command answers it and all who must see every tick are connected."""
        limit = time.monotonic() + self.start_patience_s
        while not rospy.is_shutdown() and time.monotonic() < limit:
            if self.stamps_seen and self.wait_for_nodes <= self.listeners():
                break
            with self.lock:
                self.publish()
            time.sleep(0.1)
        else:
            rospy.logwarn("sim: started after %g s without an answer to the first odometry", self.start_patience_s)
        # Once more, now that all are there: a controller forgets a path that it was sent twice while it connected.
        with self.lock:
            self.publish()
        time.sleep(0.1)
        with self.lock:
            self.started = True
            self.advance()

    def listeners(self):
        """Names of the nodes that are connected to the odometry."""
        return {connection[1] for connection in self.odometry_publisher.impl.get_stats_info()}

    def run(self):
        if self.sync:
            self.run_in_lockstep()
        else:
            self.run_in_real_time()


if __name__ == "__main__":
    Sim().run()
