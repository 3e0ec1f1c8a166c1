#!/usr/bin/env python3
"""The world: a car that obeys the control command, on a road made from the route, seen by a camera."""

import os
import threading
import time

import rospy
from ackermann_msgs.msg import AckermannDrive
from carla_msgs.msg import CarlaEgoVehicleControl
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sdc_msgs.msg import CarlaVehicleControl
from std_msgs.msg import Bool
from tf2_msgs.msg import TFMessage

from sdc_common.geometry.route import Route
from sdc_common.ros.checkpoint import Checkpoint
from sdc_common.ros.connection_watchdog import CLOCK_PATIENCE_S
from sdc_common.ros.node import LoopPublisher, refuse, spin_beside
from sdc_common.routes.waypoint_file import WaypointError, load_waypoints
from sdc_common.validation import check_between
from sdc_sim.camera.front_camera import FrontCamera
from sdc_sim.physics.ackermann import AckermannControl, AckermannGains, AckermannTarget
from sdc_sim.physics.obstacles import KINDS, Obstacles
from sdc_sim.physics.traffic_lights import TrafficLights
from sdc_sim.physics.vehicle import Vehicle, VehicleCommand, VehicleError, load_vehicle
from sdc_sim.ros.bridge_topics import BridgeTopics
from sdc_sim.ros.message_conversion import odometry_message, vehicle_transform
from sdc_sim.ros.parameters import Parameters
from sdc_sim.ros.services import SimulationServices
from sdc_sim.scenario.reader import load_lights, load_obstacles
from sdc_sim.scenario.yaml_reader import ScenarioError
from sdc_sim.simulation.command_arbiter import CommandArbiter
from sdc_sim.simulation.pause import PauseControl
from sdc_sim.simulation.placement import start_pose
from sdc_sim.simulation.sensors import OdometryNoise
from sdc_sim.simulation.simulation import OccupiedError, Simulation

UNSTAMPED = (0, 0)
# Who listens to what stands on the road is waited for so long before the first lockstep tick, wall time.
CONNECTING_S = 3.0
# In real time a picture, which keeps both cores busy for some milliseconds, lets the answer to its odometry pass, but for no longer than:
PICTURE_WAITS_S = 0.01
# After so much silence of the node that drives, another one may.
HANDOVER_S = 0.5
# What the bridge is told by and what it calls its picture, up to CARLA 0.9.4 and from 0.9.5 on.
BRIDGES = {
    "old": (CarlaVehicleControl, "/camera/rgb/front/image_color", "/camera/rgb/front/camera_info"),
    "new": (CarlaEgoVehicleControl, "/rgb_front/image", "/rgb_front/camera_info"),
}


class Sim:
    def __init__(self):
        rospy.init_node("sim", disable_rostime=True)  # it makes the clock, and need not hear it
        parameter = Parameters()
        self.sync = parameter("sync")
        self.patience_s = parameter("patience_s")
        self.unstamped_patience_s = parameter("unstamped_patience_s")
        self.start_patience_s = parameter("start_patience_s")
        self.wait_for_nodes = set(parameter("wait_for_nodes"))
        clicked_obstacle = parameter("clicked_obstacle")
        role_name, bridge, with_camera, daylight = (
            parameter("role_name"),
            parameter("bridge"),
            parameter("camera"),
            parameter("daylight"),
        )
        waypoints_path, preset = parameter("waypoints_path"), parameter("vehicle")
        for name, value, known in (
            ("clicked_obstacle", clicked_obstacle, KINDS),
            ("bridge", bridge, BRIDGES),
        ):
            if value not in known:
                refuse(f"{name} is '{value}'; write one of {', '.join(known)}")
        try:
            route_m = load_waypoints(waypoints_path)
            self.route = Route(route_m)
            self.world = self.make_world(parameter, preset)
            check_between(0.0, 1.0, daylight=daylight)
        except (WaypointError, VehicleError, ScenarioError, OccupiedError) as error:
            refuse(error)
        except (TypeError, ValueError) as error:
            refuse(f"{error}; mend it in config/sim.yaml")
        parameter.refuse_unread()

        self.lock = threading.Lock()
        self.pace = PauseControl()
        self.started = False
        self.seat = CommandArbiter(round(HANDOVER_S / self.world.tick_s))
        self.commanded = False
        self.answered = threading.Event()
        self.stamps_seen = False
        self.obeyed_stamp = UNSTAMPED
        self.kept = Checkpoint()
        self.resumed = False
        self.resume()

        ego = "/carla/" + role_name
        control, image_topic, camera_info_topic = BRIDGES[bridge]
        self.command_topic = ego + "/vehicle_control_cmd"
        self.clock_publisher = LoopPublisher("/clock", Clock)
        self.tf_publisher = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self.odometry_publisher = LoopPublisher(ego + "/odometry", Odometry)
        map_name = os.path.splitext(os.path.basename(waypoints_path))[0]
        self.topics = BridgeTopics(role_name, preset, map_name, self.world, self.sync, route_m)
        self.camera = None
        if with_camera:
            self.camera = FrontCamera(
                waypoints_path,
                ego + image_topic,
                ego + camera_info_topic,
                daylight,
                every_frame=self.sync,
            )

        rospy.Subscriber(
            self.command_topic, control, self.on_command, queue_size=10, tcp_nodelay=True
        )
        rospy.Subscriber(
            self.command_topic + "_manual",
            control,
            self.on_manual_command,
            queue_size=10,
            tcp_nodelay=True,
        )
        rospy.Subscriber(
            ego + "/vehicle_control_manual_override", Bool, self.on_override, queue_size=10
        )
        rospy.Subscriber(
            ego + "/ackermann_cmd",
            AckermannDrive,
            self.on_ackermann,
            queue_size=10,
            tcp_nodelay=True,
        )
        self.director = SimulationServices(self, clicked_obstacle)

    def make_world(self, parameter, preset):
        obstacles_path = parameter("obstacles_path")
        vehicle = Vehicle(
            load_vehicle(os.path.join(parameter("vehicles_folder"), preset + ".yaml")),
            friction=parameter("friction"),
            side_wind_mps=parameter("side_wind_mps"),
        )
        return Simulation(
            vehicle,
            parameter("tick_s"),
            parameter("command_patience_s"),
            start=start_pose(self.route, **parameter("start")),
            obstacles=Obstacles(load_obstacles(obstacles_path, self.route)),
            lights=TrafficLights(load_lights(obstacles_path, self.route)),
            noise=OdometryNoise(parameter("seed"), **parameter("odometry_noise")),
            ackermann=AckermannControl(
                vehicle.parameters, AckermannGains(**parameter("ackermann"))
            ),
            command_latency_s=parameter("command_latency_s"),
            sensor_latency_s=parameter("sensor_latency_s"),
        )

    def resume(self):
        """Go on in the world that this node was killed in, if it was."""
        state = self.kept.load()
        if state is None:
            return
        try:
            self.world.recall(state["world"])
            self.pace.recall(*state["pace"])
            self.obeyed_stamp = tuple(state["obeyed_stamp"])
            self.resumed = state["commanded"]
        except (KeyError, TypeError, ValueError) as error:
            refuse(
                f"the world that was kept when this node was killed is of another kind ({error}); start the drive anew"
            )
        rospy.logwarn("sim: was killed; the world goes on at tick %d", self.world.tick)

    def keep(self):
        """Keep all that a new process needs to go on from here."""
        state = {
            "world": self.world.memory(),
            "pace": self.pace.memory(),
            "obeyed_stamp": self.obeyed_stamp,
            "commanded": self.commanded or self.resumed,
        }
        if not self.kept.save(state) and self.kept.problem:
            rospy.logwarn_once(
                f"sim: cannot keep the world ({self.kept.problem}): if this node is killed, the drive starts anew"
            )

    def on_command(self, message):
        stamp = (message.header.stamp.secs, message.header.stamp.nsecs)
        node = message._connection_header["callerid"]
        with self.lock:
            if not self.seat.admits(node, self.world.tick):
                rospy.logwarn_throttle(
                    5.0,
                    f"sim: unheeded commands of {node} on {self.command_topic}: {self.seat.driver} drives; "
                    "stop one of them",
                )
                return
            if self.sync and stamp != UNSTAMPED:
                if stamp <= self.obeyed_stamp:
                    return  # an answer that was sent twice
                self.obeyed_stamp = stamp
            if not self.obey(message, self.command_topic):
                return
            self.commanded = True
            self.answered.set()
            self.stamps_seen = stamp != UNSTAMPED
            self.go_on_if_answered()

    def on_manual_command(self, message):
        with self.lock:
            self.obey(message, self.command_topic + "_manual", by_hand=True)

    def obey(self, message, topic, by_hand=False):
        command = VehicleCommand(
            message.throttle, message.steer, message.brake, message.hand_brake, message.reverse
        )
        return self.take(topic, lambda: self.world.obey(command, by_hand))

    def on_ackermann(self, message):
        target = AckermannTarget(
            message.steering_angle,
            message.steering_angle_velocity,
            message.speed,
            message.acceleration,
            message.jerk,
        )
        with self.lock:
            if self.take("ackermann_cmd", lambda: self.world.obey_ackermann(target)):
                self.stamps_seen = False

    def take(self, topic, give):
        """Give the world a command; returns whether it took it."""
        try:
            if give():
                rospy.logwarn_throttle(1.0, f"sim: clamped a command on {topic} to its range")
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"sim: refused a command on {topic}: {error}")
            return False
        return True

    def on_override(self, message):
        with self.lock:
            self.world.take_over(message.data)

    def go_on_if_answered(self):
        """In lockstep the world goes on when the last odometry has been answered."""
        if self.sync and self.started and self.obeyed_stamp == self.world.sensed.stamp:
            self.advance_if_due()

    def advance_if_due(self, show=True):
        """Take the next tick, unless the world is paused; returns whether it was taken."""
        if not self.pace.take():
            return False
        touches = self.world.advance()
        self.keep()
        self.publish(touches, show)
        if self.world.silent:
            rospy.logwarn_throttle(5.0, f"sim: no command on {self.command_topic}, braking")
        return True

    def publish(self, touches, show=True):
        try:
            self.publish_tick()
            self.topics.publish(touches)
        except rospy.ROSException:
            if (
                not rospy.core.is_shutdown_requested()
            ):  # a tick that the end of the node has overtaken is nobody's loss
                raise
        if show and self.camera:
            self.camera.show(self.world.sensed)

    def publish_tick(self):
        sensed = self.world.sensed
        stamp = rospy.Time(*sensed.stamp)
        odometry = odometry_message(sensed.measured, stamp)
        self.odometry_publisher.publish(odometry)
        self.clock_publisher.publish(rospy.Time(*self.world.stamp))
        if self.tf_publisher.get_num_connections():
            self.tf_publisher.publish([vehicle_transform(odometry)])

    def run_in_real_time(self):
        if self.resumed:
            self.wait_for_stack()
        due = time.monotonic()
        while not rospy.is_shutdown():
            with self.lock:
                self.answered.clear()
                taken = self.advance_if_due(show=False)
            if taken and self.camera:
                self.answered.wait(PICTURE_WAITS_S)
                with self.lock:
                    self.camera.show(self.world.sensed)
            due += self.world.tick_s
            late = time.monotonic() - due
            if late < 0.0:
                time.sleep(-late)
            else:
                due += late  # an overloaded machine slows the world down; time lost is not made up in a rush

    def run_in_lockstep(self):
        """Commands and services advance the world; here stands only what happens when no answer comes."""
        self.wait_for_stack()
        while not rospy.is_shutdown():
            tick = self.world.tick
            time.sleep(self.patience_s if self.stamps_seen else self.unstamped_patience_s)
            with self.lock:
                if self.world.tick == tick and not self.pace.waiting:
                    rospy.logwarn_throttle(
                        5.0,
                        "sim: no command carries the stamp of the last odometry; going on without",
                    )
                    self.seat.leave()
                    self.advance_if_due()

    def wait_for_stack(self):
        """Repeat the first tick until a command answers it and all who must see every tick are connected."""
        begun = time.monotonic()
        while not rospy.is_shutdown() and time.monotonic() < begun + self.start_patience_s:
            if time.monotonic() > begun + CLOCK_PATIENCE_S:
                absent = (
                    " ".join(sorted(self.wait_for_nodes - self.listeners()))
                    or f"a command on {self.command_topic}"
                )
                rospy.logwarn_once(
                    f"sim: waiting for {absent}; the first tick is repeated until then"
                )
            if self.commanded and self.wait_for_nodes <= self.listeners():
                break
            with self.lock:
                self.publish([])
            time.sleep(0.1)
        else:
            rospy.logwarn(
                "sim: started after %g s without an answer to the first odometry",
                self.start_patience_s,
            )
        limit = time.monotonic() + CONNECTING_S
        while not (rospy.is_shutdown() or self.topics.all_connected() or time.monotonic() > limit):
            time.sleep(0.02)
        # Once more, now that all are there: a controller forgets a path that it was sent twice while it connected.
        with self.lock:
            self.publish([])
        time.sleep(0.1)
        with self.lock:
            self.started = True
            self.advance_if_due()

    def listeners(self):
        """Names of the nodes that are connected to the odometry."""
        return {connection[1] for connection in self.odometry_publisher.impl.get_stats_info()}

    def run(self):
        spin_beside(self.run_in_lockstep if self.sync else self.run_in_real_time)


if __name__ == "__main__":
    Sim().run()
