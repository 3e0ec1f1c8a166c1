"""The messages of the bridge's topics, each made of the simulation at one tick."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Sequence

import rospy
from carla_msgs import msg as carla
from carla_ros_bridge import msg as bridge
from derived_object_msgs.msg import Object, ObjectArray
from geometry_msgs.msg import Point, Pose, Vector3
from sdc_msgs.msg import Obstacle, ObstacleArray
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker

from sdc_common.driving import Command
from sdc_sim.physics.ackermann import AckermannTarget
from sdc_sim.physics.obstacles import KINDS, ObstacleState
from sdc_sim.physics.traffic_lights import LANE_WIDTH_M
from sdc_sim.ros.message_conversion import MAP_FRAME, map_vector, quaternion_from_yaw
from sdc_sim.sensors.motion_sensors import TRACK_SHARE, WHEEL_RADIUS_M
from sdc_sim.simulation.simulation import Simulation
from sdc_sim.simulation.snapshot import Snapshot

_EGO_HEIGHT_M = 1.5
# Length along the lane and height of a traffic light's trigger volume.
_LINE_DEPTH_M = 1.0
_LINE_HEIGHT_M = 2.0
_MARKER_SHARE = 0.3  # opacity
_CERTAIN = 255


@dataclass
class World:
    """What the messages are made of."""

    simulation: Simulation
    role_name: str  # name of the vehicle in its topics
    preset: str  # name of the vehicle preset
    lockstep: bool = False
    running: bool = True  # not paused
    id: int = 1  # of the vehicle

    @property
    def snapshot(self) -> Snapshot:
        """The true state in the last tick."""
        return self.simulation.snapshot

    def header(self, frame: str = MAP_FRAME) -> Header:
        """Return a header in a frame with the time of the last tick."""
        return Header(stamp=rospy.Time(0, self.snapshot.stamp_ns), frame_id=frame)

    @property
    def vehicle_type(self) -> str:
        """Blueprint name of the vehicle."""
        return "vehicle." + self.preset.replace("_", ".", 1)


def light_info(world: World) -> list[carla.CarlaTrafficLightInfoList]:
    """Return the positions of the traffic lights.

    The centre of a trigger volume is the middle of the stop line; its width is a lane.
    """
    infos = []
    for plan, light in zip(world.simulation.lights, world.snapshot.traffic_lights):
        orientation = quaternion_from_yaw(light.heading_rad + math.pi)
        pose = Pose(Point(light.x_m, light.y_m, light.z_m), orientation)
        size = Vector3(_LINE_DEPTH_M, LANE_WIDTH_M, _LINE_HEIGHT_M)
        volume = carla.CarlaBoundingBox(Vector3(*plan.line_m(light), 0.0), size)
        infos.append(carla.CarlaTrafficLightInfo(light.id, pose, volume))
    return [carla.CarlaTrafficLightInfoList(infos)]


def light_status(world: World) -> list[carla.CarlaTrafficLightStatusList]:
    """Return the colours of the traffic lights."""
    return [carla.CarlaTrafficLightStatusList(_colours(world))]


def _colours(world: World) -> list[carla.CarlaTrafficLightStatus]:
    return [
        carla.CarlaTrafficLightStatus(light.id, light.state)
        for light in world.snapshot.traffic_lights
    ]


def obstacles(world: World) -> list[ObstacleArray]:
    """Return the true states of obstacles and traffic lights."""
    states = [
        Obstacle(state.id, state.kind, _pose(state), Vector3(*state.size_m), state.speed_mps)
        for state in world.snapshot.obstacles
    ]
    return [ObstacleArray(world.header(), states, _colours(world))]


def world_status(world: World) -> list[carla.CarlaStatus]:
    """Return the number of the tick, its duration, and whether the simulation runs."""
    return [
        carla.CarlaStatus(
            frame=world.simulation.tick,
            fixed_delta_seconds=world.simulation.tick_s,
            synchronous_mode=world.lockstep,
            synchronous_mode_running=world.running,
        )
    ]


def vehicle_status(world: World) -> list[carla.CarlaEgoVehicleStatus]:
    """Return speed, orientation, executed command, and acceleration in the map frame."""
    state, command = world.snapshot.state, world.simulation.commands.executed
    message = carla.CarlaEgoVehicleStatus(header=world.header())
    message.velocity = math.hypot(state.speed_mps, state.lateral_speed_mps)
    message.acceleration.linear = map_vector(
        state.yaw_rad, state.longitudinal_acceleration_mps2, state.lateral_acceleration_mps2
    )
    message.orientation = quaternion_from_yaw(state.yaw_rad, world.snapshot.pitch_rad)
    message.control = carla.CarlaEgoVehicleControl(
        header=message.header, gear=-1 if command.reverse else 1, **fields_of(command)
    )
    return [message]


def vehicle_info(world: World) -> list[carla.CarlaEgoVehicleInfo]:
    """Return the description of the vehicle; the model has no motor and gears: they are zero."""
    p = world.simulation.vehicle.parameters
    message = carla.CarlaEgoVehicleInfo(
        id=world.id,
        type=world.vehicle_type,
        rolename=world.role_name,
        mass=p.mass_kg,
        drag_coefficient=p.drag_area_m2,
        use_gear_autobox=True,
    )
    message.center_of_mass.z = p.cg_height_m
    # Distance ahead of the centre of gravity, largest angle, force of the brake and hand brake.
    front_n = p.brake_force_n * p.brake_front_share
    rear_n = p.brake_force_n * (1.0 - p.brake_front_share)
    axles = (
        (p.front_axle_m, p.max_wheel_angle_rad, front_n, 0.0),
        (-p.rear_axle_m, 0.0, rear_n, p.hand_brake_force_n),
    )
    left_m = 0.5 * TRACK_SHARE * p.width_m
    message.wheels = [
        carla.CarlaEgoVehicleInfoWheel(
            tire_friction=p.tyre_friction,
            radius=WHEEL_RADIUS_M,
            max_steer_angle=angle_rad,
            max_brake_torque=0.5 * WHEEL_RADIUS_M * brake_n,
            max_handbrake_torque=0.5 * WHEEL_RADIUS_M * hand_brake_n,
            position=Vector3(ahead_m, side_m, WHEEL_RADIUS_M),
        )
        for ahead_m, angle_rad, brake_n, hand_brake_n in axles
        for side_m in (left_m, -left_m)
    ]
    return [message]


def collisions(world: World) -> list[carla.CarlaCollisionEvent]:
    """Return the contacts that began in the last tick."""
    return [
        carla.CarlaCollisionEvent(
            header=world.header(world.role_name),
            other_actor_id=event.id,
            normal_impulse=Vector3(event.impulse_x_ns, event.impulse_y_ns, 0.0),
        )
        for event in world.snapshot.collisions
    ]


def obstacle_marker(world: World, obstacle: ObstacleState) -> Marker:
    """Return an obstacle as a box for RViz, in the namespace `obstacles`."""
    colour = (*KINDS[obstacle.kind].colour, 1.0)
    marker = _box(world, obstacle.id, _pose(obstacle), obstacle.size_m, colour)
    marker.ns = "obstacles"
    return marker


def _box(world: World, number: int, pose: Pose, size: Sequence[float], colour: Any) -> Marker:
    """Return a box of this size [m] on the ground, in red, green, blue and opacity."""
    above = Point(pose.position.x, pose.position.y, pose.position.z + 0.5 * size[2])
    return Marker(
        header=world.header(),
        id=number,
        type=Marker.CUBE,
        action=Marker.ADD,
        pose=Pose(above, pose.orientation),
        scale=Vector3(*size),
        color=ColorRGBA(*colour),
    )


def _pose(place: Any) -> Pose:
    """Return the pose of a state on the ground."""
    orientation = quaternion_from_yaw(place.yaw_rad, place.pitch_rad)
    return Pose(Point(place.x_m, place.y_m, place.z_m), orientation)


def other_objects(world: World) -> list[ObjectArray]:
    """Return the obstacles as objects."""
    return [ObjectArray(world.header(), _others(world))]


def all_objects(world: World) -> list[ObjectArray]:
    """Return the vehicle and the obstacles as objects."""
    return [ObjectArray(world.header(), [_own(world), *_others(world)])]


def object_markers(world: World) -> list[Marker]:
    """Return the box of each object for RViz: green for the vehicle, red for others."""
    markers = []
    for body in (_own(world), *_others(world)):
        colour = (0.0, 255.0, 0.0) if body.id == world.id else (255.0, 0.0, 0.0)
        size = body.shape.dimensions
        markers.append(_box(world, body.id, body.pose, size, (*colour, _MARKER_SHARE)))
        markers[-1].text = f"id = {body.id}"
    return markers


def _own(world: World) -> Object:
    """Return the vehicle as an object; twist and acceleration are in the map frame."""
    state, parameters = world.snapshot.state, world.simulation.vehicle.parameters
    place = state.x_m, state.y_m, state.yaw_rad
    size = parameters.length_m, parameters.width_m, _EGO_HEIGHT_M
    motion = state.speed_mps, world.snapshot.z_m, world.snapshot.pitch_rad
    message = _object(world, ObstacleState(world.id, "car", *place, *size, *motion))
    message.twist.linear = map_vector(state.yaw_rad, state.speed_mps, state.lateral_speed_mps)
    message.twist.angular.z = state.yaw_rate_radps
    message.accel.linear = map_vector(
        state.yaw_rad, state.longitudinal_acceleration_mps2, state.lateral_acceleration_mps2
    )
    return message


def _others(world: World) -> list[Object]:
    return [_object(world, obstacle) for obstacle in world.snapshot.obstacles]


def _object(world: World, state: ObstacleState) -> Object:
    """Return an obstacle as an object; its twist is in the map frame."""
    message = Object(
        header=world.header(),
        id=state.id,
        detection_level=Object.OBJECT_TRACKED,
        pose=_pose(state),
        shape=SolidPrimitive(SolidPrimitive.BOX, state.size_m),
    )
    message.twist.linear = map_vector(state.yaw_rad, state.speed_mps, 0.0)
    shown_as = KINDS[state.kind].shown_as
    if shown_as:
        message.object_classified = True
        message.classification = getattr(Object, "CLASSIFICATION_" + shown_as)
        message.classification_certainty = _CERTAIN
        message.classification_age = world.simulation.tick
    return message


def actor_list(world: World) -> list[carla.CarlaActorList]:
    """Return the vehicle, the obstacles and the traffic lights as actors of CARLA."""
    observed = world.snapshot
    actors = [carla.CarlaActorInfo(world.id, 0, world.vehicle_type, world.role_name)]
    actors += [
        carla.CarlaActorInfo(state.id, 0, KINDS[state.kind].blueprint, "")
        for state in observed.obstacles
    ]
    actors += [
        carla.CarlaActorInfo(light.id, 0, "traffic.traffic_light", "")
        for light in observed.traffic_lights
    ]
    return [carla.CarlaActorList(actors)]


def control_info(world: World) -> list[bridge.EgoVehicleControlInfo]:
    """Return limits, target, motion and executed command as the bridge 0.9.3 publishes them."""
    commands, state, header = world.simulation.commands, world.snapshot.state, world.header()
    gains = commands.ackermann.gains
    limits = bridge.EgoVehicleControlMaxima(
        max_steering_angle=world.simulation.vehicle.parameters.max_wheel_angle_rad,
        max_speed=gains.max_speed_mps,
        max_accel=gains.acceleration_mps2,
        max_decel=gains.braking_mps2,
        max_pedal=1.0,
    )
    target = commands.ackermann_target
    demand = target or AckermannTarget()
    return [
        bridge.EgoVehicleControlInfo(
            header=header,
            restrictions=limits,
            target=bridge.EgoVehicleControlTarget(
                # As in the bridge, positive to the right.
                steering_angle=-demand.steering_angle_rad,
                speed=demand.speed_mps,
                speed_abs=abs(demand.speed_mps),
                accel=demand.acceleration_mps2,
                jerk=demand.jerk_mps3,
            ),
            current=bridge.EgoVehicleControlCurrent(
                time_sec=header.stamp.to_sec(),
                speed=state.speed_mps,
                speed_abs=abs(state.speed_mps),
                accel=state.longitudinal_acceleration_mps2,
            ),
            state=bridge.EgoVehicleControlState(status="n/a" if target is None else "driving"),
            output=bridge.CarlaVehicleControl(header=header, **fields_of(commands.executed)),
        )
    ]


def fields_of(command: Command) -> dict[str, Any]:
    """Return the fields that the messages of a command have, without its stamp."""
    fields = dict(vars(command))
    del fields["stamp_ns"]
    return fields
