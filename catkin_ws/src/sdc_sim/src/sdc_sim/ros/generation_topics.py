"""The topics that only some generations of the CARLA bridge publish."""

from __future__ import annotations

from typing import Any, Callable, Collection, Sequence

import rospy
from carla_msgs.msg import (
    CarlaActorList,
    CarlaTrafficLightInfoList,
    CarlaTrafficLightStatusList,
)
from carla_ros_bridge.msg import EgoVehicleControlInfo
from derived_object_msgs.msg import Object, ObjectArray
from std_msgs.msg import Float32, Header, String
from visualization_msgs.msg import Marker

from sdc_sim.physics.traffic_lights import TrafficLightState
from sdc_sim.ros.bridge_generations import BridgeGeneration
from sdc_sim.ros.message_conversion import (
    MAP_FRAME,
    light_info_message,
    light_status_message,
    vehicle_type,
)
from sdc_sim.ros.object_messages import (
    actor_list_message,
    control_info_message,
    ego_object,
    object_array,
    object_marker,
    obstacle_object,
)
from sdc_sim.simulation.observation import Observation
from sdc_sim.simulation.simulation import Simulation

_EGO_HEIGHT_M = 1.5


class GenerationTopics:
    """Publishes the topics of one generation in each tick, those without subscribers excepted.

    Args:
        generation: the generation
        role_name: name of the vehicle in its topics
        preset: name of the vehicle preset
        map_name: name of the map
        opendrive: the map as OpenDRIVE
        simulation: the simulation
        others: names of topics that another class publishes
    """

    def __init__(
        self,
        generation: BridgeGeneration,
        role_name: str,
        preset: str,
        map_name: str,
        opendrive: str,
        simulation: Simulation,
        others: Collection[str] = (),
    ):
        self._generation = generation
        self._simulation = simulation
        self._role_name = role_name
        self._vehicle_type = vehicle_type(preset)
        self._lights: tuple[TrafficLightState, ...] | None = None
        makers: dict[str, tuple[type, Callable[[Observation], Sequence[Any]]]] = {
            "/carla/objects": (ObjectArray, self._world_objects),
            "/objects": (ObjectArray, self._other_objects),
            "/carla/actor_list": (CarlaActorList, self._actor_list),
            "/carla/vehicle_marker": (Marker, self._markers),
            "/carla/marker": (Marker, self._markers),
            "/speedometer": (Float32, lambda observed: [Float32(observed.state.speed_mps)]),
            "/ego_vehicle_control_info": (EgoVehicleControlInfo, self._control_info),
        }
        self._publishers = [
            (
                rospy.Publisher(vehicle_topic(role_name, name), message_class, queue_size=100),
                maker,
            )
            for name, (message_class, maker) in makers.items()
            if name in generation.topics and name not in others
        ]
        self._latched: list[rospy.Publisher] = []
        self._light_status = None
        if "/carla/traffic_lights" in generation.topics:
            self._light_status = self._latch("/carla/traffic_lights", CarlaTrafficLightStatusList)
            self._latch("/carla/traffic_lights_info", CarlaTrafficLightInfoList).publish(
                light_info_message(simulation.lights.plans, simulation.observation.traffic_lights)
            )
        self._publish_map(map_name, opendrive)

    def _latch(self, topic: str, message_class: type) -> rospy.Publisher:
        publisher = rospy.Publisher(topic, message_class, queue_size=10, latch=True)
        self._latched.append(publisher)  # rospy unregisters a publisher that is not referenced
        return publisher

    def _publish_map(self, map_name: str, opendrive: str) -> None:
        map_class = self._generation.map_class
        if map_class is None:
            return
        publisher = self._latch("/carla/map", map_class)
        if map_class is String:
            publisher.publish(opendrive)
        else:
            publisher.publish(Header(frame_id=MAP_FRAME), map_name, opendrive)

    def publish(self, observation: Observation) -> None:
        """Publish an observation."""
        if self._light_status is not None and observation.traffic_lights != self._lights:
            self._lights = observation.traffic_lights
            self._light_status.publish(light_status_message(self._lights))
        for publisher, maker in self._publishers:
            if publisher.get_num_connections():
                for message in maker(observation):
                    publisher.publish(message)

    def _others(self, observation: Observation) -> list[Object]:
        stamp, age = rospy.Time(*observation.stamp), self._simulation.tick
        return [obstacle_object(one, stamp, age) for one in observation.obstacles]

    def _all(self, observation: Observation) -> list[Object]:
        parameters = self._simulation.vehicle.parameters
        stamp, age = rospy.Time(*observation.stamp), self._simulation.tick
        own = ego_object(observation.state, parameters, _EGO_HEIGHT_M, stamp, age)
        return [own, *self._others(observation)]

    def _world_objects(self, observation: Observation) -> list[ObjectArray]:
        # The vehicle's own list came with 0.9.5; before, the world's list left the vehicle out.
        has_own_list = "/objects" in self._generation.topics
        objects = self._all(observation) if has_own_list else self._others(observation)
        return [object_array(objects, rospy.Time(*observation.stamp))]

    def _other_objects(self, observation: Observation) -> list[ObjectArray]:
        return [object_array(self._others(observation), rospy.Time(*observation.stamp))]

    def _markers(self, observation: Observation) -> list[Marker]:
        return [object_marker(one) for one in self._all(observation)]

    def _actor_list(self, observation: Observation) -> list[CarlaActorList]:
        return [
            actor_list_message(
                self._vehicle_type,
                self._role_name,
                observation.obstacles,
                observation.traffic_lights,
            )
        ]

    def _control_info(self, observation: Observation) -> list[EgoVehicleControlInfo]:
        commands = self._simulation.commands
        return [
            control_info_message(
                observation.state,
                commands.executed,
                commands.ackermann_target,
                self._simulation.vehicle.parameters,
                commands.ackermann_gains,
                rospy.Time(*observation.stamp),
            )
        ]


def vehicle_topic(role_name: str, name: str) -> str:
    """Return the full name of a topic; a name without /carla is one of the vehicle."""
    return name if name.startswith("/carla/") else f"/carla/{role_name}{name}"
