"""The steering methods of the comparison: those of the paper and those of this project."""

from __future__ import annotations

import functools
import math
from typing import Any, Callable, Mapping, NamedTuple

from sdc_common.geometry.angles import wrap_angle
from sdc_common.geometry.polyline import Place
from sdc_experiments.snider.courses import Course
from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles
from sdc_package.steering.kinematic import ChainedForm
from sdc_package.steering.loader import load_steering
from sdc_package.steering.lqr import LqrFeedforwardSteering, LqrSteering
from sdc_package.steering.pure_pursuit import pure_pursuit_angle
from sdc_package.steering.stanley import stanley_angle
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.physics.vehicle_parameters import VehicleParameters

# Stanley's gain is that of the paper. The other gains are not known here: each is the one value
# whose errors are nearest to those of the paper.
PURE_PURSUIT_S = 0.45
STANLEY_PER_S = 2.0
KINEMATIC_PER_M = 0.4
LQR_WEIGHTS = {
    "cross_track_weight": 0.12,
    "cross_track_rate_weight": 0.0,
    "heading_weight": 1.0,
    "heading_rate_weight": 0.0,
    "steer_weight": 1.0,
}

# Methods of this project that take part, with their parameters in config/simple_controller.yaml.
OWN_METHODS = ("stanley", "stanley_compensated")

_TICK_S = 0.01
_OWN_TICK_S = 0.05
_OWN_LOOK_AHEAD_M, _OWN_STEP_M = 25, 1.0

# (course, state of the car, place of its controlled point) -> wheel angle, positive left [rad]
SteeringFunction = Callable[[Course, VehicleState, Place], float]


class Method(NamedTuple):
    """A way of steering."""

    name: str  # name in the tables
    # Distance of the controlled and measured point ahead of the centre of gravity [m]
    point_m: float
    tick_s: float  # time between two commands [s]
    # Returns a steering function without state of an earlier drive
    build: Callable[[], SteeringFunction]


def own_name(method: str) -> str:
    """Return the name in the tables of a method of this project."""
    return f"this project: {method}"


def all_methods(car: VehicleParameters, axles: Axles, config: Mapping[str, Any]) -> list[Method]:
    """Return the five methods of the paper, then those of config/simple_controller.yaml.

    The axles are those that the controllers know.
    """
    front, rear = car.front_axle_m, -car.rear_axle_m
    gyration_m = math.sqrt(car.yaw_inertia_kgm2 / car.mass_kg)
    model = {**LQR_WEIGHTS, "gyration_m": gyration_m, "tick_s": _TICK_S, "preview_s": 0.0}
    pursuit = functools.partial(_pure_pursuit, rear, car.wheelbase_m)
    lqr = functools.partial(_state_feedback, LqrSteering(axles, **model))
    feedforward = functools.partial(_state_feedback, LqrFeedforwardSteering(axles, **model))
    return [
        Method("pure pursuit", rear, _TICK_S, lambda: pursuit),
        Method("Stanley", front, _TICK_S, lambda: _stanley),
        Method("kinematic", rear, _TICK_S, functools.partial(_kinematic, car.wheelbase_m)),
        Method("LQR", 0.0, _TICK_S, lambda: lqr),
        Method("LQR+FF", 0.0, _TICK_S, lambda: feedforward),
        *(
            Method(own_name(name), 0.0, _OWN_TICK_S, functools.partial(_own, name, axles, config))
            for name in OWN_METHODS
        ),
    ]


def point_of(state: VehicleState, ahead_m: float) -> tuple[float, float]:
    """Return the point of the car that is `ahead_m` ahead of its centre of gravity [m]."""
    return (
        state.x_m + ahead_m * math.cos(state.yaw_rad),
        state.y_m + ahead_m * math.sin(state.yaw_rad),
    )


def _pure_pursuit(
    rear_m: float, wheelbase_m: float, course: Course, state: VehicleState, rear: Place
) -> float:
    """Steer the rear axle to the point of the road at the look-ahead distance."""
    x, y = point_of(state, rear_m)
    look_ahead = PURE_PURSUIT_S * state.speed_mps
    s = rear.s_m + look_ahead
    # Three steps of Newton's method find the point of the road at this straight distance.
    for _ in range(3):
        goal_x, goal_y = course.line.point_at(s)
        heading = course.line.heading_at(s)
        distance = math.hypot(goal_x - x, goal_y - y)
        slope = ((goal_x - x) * math.cos(heading) + (goal_y - y) * math.sin(heading)) / distance
        s += (look_ahead - distance) / max(0.3, slope)
    goal_x, goal_y = course.line.point_at(s)
    alpha = math.atan2(goal_y - y, goal_x - x) - state.yaw_rad
    return pure_pursuit_angle(alpha, look_ahead, wheelbase_m)


def _stanley(_course: Course, state: VehicleState, front: Place) -> float:
    """Steer the front axle with Stanley's law."""
    heading_error = wrap_angle(front.heading_rad - state.yaw_rad)
    return stanley_angle(heading_error, front.cross_track_m, state.speed_mps, STANLEY_PER_S)


def _kinematic(wheelbase_m: float) -> SteeringFunction:
    """Return the kinematic controller at the rear axle, which has a state."""
    form = ChainedForm(wheelbase_m)

    def steer(course: Course, state: VehicleState, rear: Place) -> float:
        before, curve, after = (course.curvature_at(rear.s_m + ds) for ds in (-0.1, 0.0, 0.1))
        error = wrap_angle(state.yaw_rad - rear.heading_rad)
        driven_m, slope = state.speed_mps * _TICK_S, (after - before) / 0.2
        return form.wheel_angle(driven_m, rear.cross_track_m, error, curve, slope, KINEMATIC_PER_M)

    return steer


def _state_feedback(law: LqrSteering, course: Course, state: VehicleState, centre: Place) -> float:
    """Steer the centre of gravity with the full state of the car."""
    curvature = course.curvature_at(centre.s_m)
    error = wrap_angle(state.yaw_rad - centre.heading_rad)
    rate = state.speed_mps * math.sin(error) + state.lateral_speed_mps * math.cos(error)
    turning = state.yaw_rate_radps - state.speed_mps * curvature
    return law.feedback(centre.cross_track_m, rate, error, turning, curvature, state.speed_mps)


def _own(name: str, axles: Axles, config: Mapping[str, Any]) -> SteeringFunction:
    """Return a method of this project, which follows points as the local planner publishes them."""
    steering, path = load_steering(name, config[name], axles), ReferencePath()

    def steer(course: Course, state: VehicleState, centre: Place) -> float:
        first = math.ceil(centre.s_m / _OWN_STEP_M)
        ahead = (i * _OWN_STEP_M for i in range(first, first + _OWN_LOOK_AHEAD_M + 1))
        path.update([(*course.line.point_at(s_m), state.speed_mps) for s_m in ahead])
        return steering.wheel_angle(
            path, state.x_m, state.y_m, state.yaw_rad, state.speed_mps, state.yaw_rate_radps
        )

    return steer
