#!/usr/bin/env python3
"""Services of CARLA's bridge: run, pause, step, spawn and destroy; and the leaderboard's route."""

import fnmatch
import itertools
import math
import random
import threading

import rosgraph
import rospy
from carla_msgs import msg as carla
from carla_msgs.srv import DestroyObject, GetBlueprints, SpawnObject
from geometry_msgs.msg import Point, Pose
from nav_msgs.msg import Odometry
from sdc_msgs.msg import Obstacle, ObstacleArray
from sdc_msgs.srv import SetObstacle
from sensor_msgs.msg import NavSatFix
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from sdc_common.geometry.geodesy import geodetic_from_map
from sdc_common.geometry.road_line import road_route
from sdc_common.ros.node import watch_connections
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.physics.obstacles import KINDS
from sdc_sim.ros.message_conversion import MAP_FRAME, quaternion_from_yaw
from sdc_sim.yaml_document import packaged_config

CONTROL = {
    carla.CarlaControl.PLAY: "resume",
    carla.CarlaControl.PAUSE: "pause",
    carla.CarlaControl.STEP_ONCE: "step",
}
# The kinds of obstacles, by the first word of their blueprint.
FAMILIES = {KINDS[kind].blueprint.split(".")[0]: kind for kind in reversed([*KINDS])}
SENSORS = packaged_config("blueprints")
ODOMETRY = "sensor.pseudo.odom"
EGO_ID = 1
FIRST_SENSOR_ID = 10000


class BridgeServices:
    def __init__(self):
        rospy.init_node("bridge_services")
        self.ego = "/carla/" + rospy.get_param("/sim/role_name")
        self.route = road_route(load_waypoints(rospy.get_param("/sim/waypoints_path")))
        self.set_obstacle = rospy.ServiceProxy("/sim/set_obstacle", SetObstacle)
        self.lock = threading.RLock()
        self.sensor_ids = itertools.count(FIRST_SENSOR_ID)
        self.prefixes = {EGO_ID: self.ego}  # of the topics of each actor and sensor, by ID
        self.parents: dict[int, int] = {}  # of what was spawned
        self.topics: dict[int, list] = {}  # that end with it
        self.walks: dict[int, tuple[float, float]] = {}  # heading and speed of pedestrians
        self.odometry: dict[int, rospy.Publisher] = {}  # of obstacles
        self.watch: rospy.Subscriber | None = None  # of the obstacles, once there are some
        self.seen: set[int] = set()  # obstacles that the simulator has published
        rospy.wait_for_service("/sim/set_obstacle")
        self.publish_route()
        rospy.Subscriber("/carla/control", carla.CarlaControl, self.on_control, queue_size=10)
        rospy.Service("/carla/spawn_object", SpawnObject, self.on_spawn)
        rospy.Service("/carla/destroy_object", DestroyObject, self.on_destroy)
        rospy.Service("/carla/get_blueprints", GetBlueprints, self.on_blueprints)

    def on_control(self, message):
        try:
            rospy.ServiceProxy("/sim/" + CONTROL[message.command], Trigger)()
        except (KeyError, rospy.ServiceException) as error:
            rospy.logwarn("bridge_services: refused command %d: %s", message.command, error)

    def on_spawn(self, request):
        try:
            with self.lock:
                return self.spawn(request), ""
        except (ValueError, rospy.ServiceException) as error:
            rospy.logwarn("bridge_services: no %s '%s': %s", request.type, request.id, error)
            return -1, str(error)

    def spawn(self, request):
        carrier = request.attach_to
        if carrier and carrier not in self.prefixes:
            raise ValueError(f"there is no actor {carrier} to attach it to")
        prefix = f"{self.prefixes[carrier] if carrier else '/carla'}/{request.id}"
        if request.id and prefix in self.prefixes.values():
            raise ValueError(f"the id '{request.id}' is in use; choose another one")
        if not rosgraph.names.is_legal_name(prefix):
            raise ValueError(f"the id '{request.id}' is no name of a topic; use a-z, 0-9 and _")
        if request.type in SENSORS:
            number = self.spawn_sensor(request, SENSORS[request.type].format(prefix=prefix))
        elif request.type.split(".")[0] not in FAMILIES:
            raise ValueError("unknown type; /carla/get_blueprints lists those that there are")
        elif carrier:
            raise ValueError("only sensors are attached; set attach_to to 0")
        else:
            kind = FAMILIES[request.type.split(".")[0]]
            pose = self.random_pose() if request.random_pose else request.transform
            number = self.call(Obstacle(kind=kind, pose=pose))
            prefix = prefix if request.id else f"/carla/{number}"
            if self.watch is None:
                topic = self.ego + "/obstacles"
                self.watch = rospy.Subscriber(topic, ObstacleArray, self.on_obstacles)
            if kind == "pedestrian":
                self.topics[number] = [
                    rospy.Subscriber(
                        prefix + "/walker_control_cmd", carla.CarlaWalkerControl, self.walk, number
                    )
                ]
        self.prefixes[number], self.parents[number] = prefix, carrier
        return number

    def spawn_sensor(self, request, topic):
        number = next(self.sensor_ids)
        if request.type == ODOMETRY and EGO_ID < request.attach_to < FIRST_SENSOR_ID:
            publisher = rospy.Publisher(topic, Odometry, queue_size=10)
            self.odometry[request.attach_to] = publisher
            self.topics[number] = [publisher]
            return number
        published, subscribed, _ = rosgraph.Master(rospy.get_name()).getSystemState()
        if not any(
            name == topic and {"/sim", "/front_camera"} & {*nodes}
            for name, nodes in published + subscribed
        ):
            raise ValueError(f"the simulator has none on {topic}; sensors:= turns them on at start")
        return number

    def random_pose(self):
        s = random.uniform(0.0, self.route.length_m)
        (x, y), yaw = self.route.line.point_at(s), self.route.line.direction_at(s)
        return Pose(Point(x, y, 0.0), quaternion_from_yaw(yaw))

    def call(self, obstacle, remove=False):
        answer = self.set_obstacle(obstacle, remove)
        if answer.error_string:
            raise ValueError(answer.error_string)
        return answer.id

    def walk(self, message, number):
        ahead = message.direction
        yaw, speed = math.atan2(ahead.y, ahead.x), message.speed
        if not (ahead.x or ahead.y):
            yaw, speed = self.walks.get(number, (0.0, 0.0))[0], 0.0
        if self.walks.get(number) == (yaw, speed):
            return
        pose = Pose(orientation=quaternion_from_yaw(yaw))
        try:
            self.call(Obstacle(id=number, pose=pose, speed=speed))
            self.walks[number] = yaw, speed
        except (ValueError, rospy.ServiceException) as error:
            rospy.logwarn_throttle(1.0, f"bridge_services: pedestrian {number}: {error}")

    def on_obstacles(self, message):
        """Publish the odometry of spawned obstacles, and forget those that a reset removed."""
        states = {obstacle.id: obstacle for obstacle in message.obstacles}
        with self.lock:
            for number in self.seen - {*states}:
                self.forget(number)
            self.seen = {*states} & {*self.parents}
            for number in self.seen & {*self.odometry}:
                odometry = Odometry(header=message.header)
                odometry.child_frame_id = self.prefixes[number].rpartition("/")[2]
                odometry.pose.pose = states[number].pose
                odometry.twist.twist.linear.x = states[number].speed
                self.odometry[number].publish(odometry)

    def on_destroy(self, request):
        with self.lock:
            try:
                if request.id not in self.parents:
                    raise ValueError("it was not spawned")
                if request.id < FIRST_SENSOR_ID:
                    self.call(Obstacle(id=request.id), remove=True)
            except (ValueError, rospy.ServiceException) as error:
                rospy.logwarn("bridge_services: %d not destroyed: %s", request.id, error)
                return False
            self.forget(request.id)
        return True

    def forget(self, number):
        """End the topics of an actor or sensor, and of what it carries."""
        for child in [child for child, parent in self.parents.items() if parent == number]:
            self.forget(child)
        self.seen.discard(number)
        for table in (self.prefixes, self.parents, self.walks, self.odometry):
            table.pop(number, None)
        for topic in self.topics.pop(number, ()):
            topic.unregister()

    def on_blueprints(self, request):
        names = [*(kind.blueprint for kind in KINDS.values()), *SENSORS]
        # As in the bridge, the filter does not count for the sensors that only the bridge has.
        return [
            sorted(
                name
                for name in names
                if ".pseudo." in name or fnmatch.fnmatchcase(name, request.filter or "*")
            )
        ]

    def publish_route(self):
        """Publish the route as the leaderboard does, unless the map is secret."""
        if not hasattr(carla, "CarlaRoute") or not (
            rospy.get_param("/sim/truth") or rospy.get_param("/sim/ground_truth")
        ):
            return
        header, points = Header(frame_id=MAP_FRAME), self.route.points.tolist()
        options = [carla.CarlaRoute.LANEFOLLOW] * len(points)
        poses = [
            Pose(Point(x, y, 0.0), quaternion_from_yaw(yaw))
            for (x, y), yaw in zip(points, self.route.heading.tolist())
        ]
        fixes = [
            NavSatFix(latitude=latitude, longitude=longitude)
            for latitude, longitude in (geodetic_from_map(x, y) for x, y in points)
        ]
        for name, message in (
            ("global_plan", carla.CarlaRoute(header, options, poses)),
            ("global_plan_gnss", carla.CarlaGnssRoute(header, options, fixes)),
        ):
            publisher = rospy.Publisher(
                f"{self.ego}/{name}", type(message), queue_size=1, latch=True
            )
            publisher.publish(message)


if __name__ == "__main__":
    BridgeServices()
    watch_connections()
    rospy.spin()
