"""Messages of CARLA's actors: objects, actors, markers, and the control of the vehicle."""

from __future__ import annotations

from typing import Iterable

import rospy
from carla_msgs.msg import CarlaActorInfo, CarlaActorList
from carla_ros_bridge.msg import (
    CarlaVehicleControl,
    EgoVehicleControlCurrent,
    EgoVehicleControlInfo,
    EgoVehicleControlMaxima,
    EgoVehicleControlState,
    EgoVehicleControlTarget,
)
from derived_object_msgs.msg import Object, ObjectArray
from geometry_msgs.msg import Point, Pose, Vector3
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker

from sdc_sim.physics.ackermann import AckermannGains, AckermannTarget
from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import TrafficLightState
from sdc_sim.physics.vehicle import VehicleCommand, VehicleState
from sdc_sim.physics.vehicle_parameters import VehicleParameters
from sdc_sim.ros.message_conversion import EGO_ID, MAP_FRAME, map_vector, quaternion_from_yaw

_CLASSES = {"car": Object.CLASSIFICATION_CAR, "pedestrian": Object.CLASSIFICATION_PEDESTRIAN}
# Blueprints of CARLA; a client tells the kinds of actors apart by the first word.
_BLUEPRINTS = {
    "car": "vehicle.audi.a2",
    "pedestrian": "walker.pedestrian.0001",
    "obstacle": "static.prop.box01",
}
_MARKER_SHARE = 0.3  # opacity
_CERTAIN = 255


def ego_object(
    state: VehicleState, parameters: VehicleParameters, height_m: float, stamp: rospy.Time, age: int
) -> Object:
    """Return the vehicle as an object; twist and acceleration are in the map frame."""
    message = _object(EGO_ID, "car", state.x_m, state.y_m, state.yaw_rad, stamp, age)
    message.shape.dimensions = [parameters.length_m, parameters.width_m, height_m]
    message.twist.linear = map_vector(state.yaw_rad, state.speed_mps, state.lateral_speed_mps)
    message.twist.angular.z = state.yaw_rate_radps
    message.accel.linear = map_vector(
        state.yaw_rad, state.longitudinal_acceleration_mps2, state.lateral_acceleration_mps2
    )
    return message


def obstacle_object(one: ObstacleState, stamp: rospy.Time, age: int) -> Object:
    """Return an obstacle as an object; its twist is in the map frame."""
    message = _object(one.id, one.kind, one.x_m, one.y_m, one.yaw_rad, stamp, age)
    message.shape.dimensions = [one.length_m, one.width_m, one.height_m]
    message.twist.linear = map_vector(one.yaw_rad, one.speed_mps, 0.0)
    return message


def _object(
    number: int, kind: str, x_m: float, y_m: float, yaw_rad: float, stamp: rospy.Time, age: int
) -> Object:
    message = Object(
        header=Header(stamp=stamp, frame_id=MAP_FRAME),
        id=number,
        detection_level=Object.OBJECT_TRACKED,
        pose=Pose(Point(x_m, y_m, 0.0), quaternion_from_yaw(yaw_rad)),
    )
    message.shape.type = SolidPrimitive.BOX
    if kind in _CLASSES:
        message.object_classified = True
        message.classification = _CLASSES[kind]
        message.classification_certainty = _CERTAIN
        message.classification_age = age
    return message


def object_array(objects: Iterable[Object], stamp: rospy.Time) -> ObjectArray:
    """Return the message of these objects."""
    return ObjectArray(Header(stamp=stamp, frame_id=MAP_FRAME), list(objects))


def object_marker(message: Object) -> Marker:
    """Return the box of an object for RViz: green for the vehicle, red for others."""
    own = message.id == EGO_ID
    length_m, width_m, height_m = message.shape.dimensions
    position = message.pose.position
    return Marker(
        header=message.header,
        id=message.id,
        type=Marker.CUBE,
        pose=Pose(Point(position.x, position.y, 0.5 * height_m), message.pose.orientation),
        scale=Vector3(length_m, width_m, height_m),
        color=ColorRGBA(0.0 if own else 255.0, 255.0 if own else 0.0, 0.0, _MARKER_SHARE),
        text=f"id = {message.id}",
    )


def actor_list_message(
    vehicle_type: str,
    role_name: str,
    obstacles: Iterable[ObstacleState],
    lights: Iterable[TrafficLightState],
) -> CarlaActorList:
    """Return the vehicle, the obstacles and the traffic lights as actors of CARLA."""
    actors = [CarlaActorInfo(EGO_ID, 0, vehicle_type, role_name)]
    actors += [CarlaActorInfo(one.id, 0, _BLUEPRINTS[one.kind], "") for one in obstacles]
    actors += [CarlaActorInfo(light.id, 0, "traffic.traffic_light", "") for light in lights]
    return CarlaActorList(actors)


def control_info_message(
    state: VehicleState,
    executed: VehicleCommand,
    target: AckermannTarget | None,
    parameters: VehicleParameters,
    gains: AckermannGains | None,
    stamp: rospy.Time,
) -> EgoVehicleControlInfo:
    """Return limits, target, motion and executed command as the bridge 0.9.3 publishes them.

    Args:
        state: state of the vehicle
        executed: command of this tick
        target: target of ackermann_cmd; None while pedals are commanded
        parameters: the vehicle
        gains: limits of ackermann_cmd
        stamp: time of the state
    """
    header = Header(stamp=stamp, frame_id=MAP_FRAME)
    limits = EgoVehicleControlMaxima(
        max_steering_angle=parameters.max_wheel_angle_rad, max_pedal=1.0
    )
    if gains is not None:
        limits.max_speed = gains.max_speed_mps
        limits.max_accel, limits.max_decel = gains.acceleration_mps2, gains.braking_mps2
    demand = target or AckermannTarget()
    return EgoVehicleControlInfo(
        header=header,
        restrictions=limits,
        target=EgoVehicleControlTarget(
            # As in the bridge, positive to the right.
            steering_angle=-demand.steering_angle_rad,
            speed=demand.speed_mps,
            speed_abs=abs(demand.speed_mps),
            accel=demand.acceleration_mps2,
            jerk=demand.jerk_mps3,
        ),
        current=EgoVehicleControlCurrent(
            time_sec=stamp.to_sec(),
            speed=state.speed_mps,
            speed_abs=abs(state.speed_mps),
            accel=state.longitudinal_acceleration_mps2,
        ),
        state=EgoVehicleControlState(status="n/a" if target is None else "driving"),
        output=CarlaVehicleControl(
            header=header,
            throttle=executed.throttle,
            steer=executed.steer,
            brake=executed.brake,
            hand_brake=executed.hand_brake,
            reverse=executed.reverse,
        ),
    )
