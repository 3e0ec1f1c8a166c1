"""The steering methods of the comparison: those of the paper and those of this project."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any, Callable, Mapping

from sdc_common.geometry.angles import wrap_angle
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
_OWN_LOOK_AHEAD_M = 25.0
_OWN_STEP_M = 1.0

# (course, state of the car, arc length at its centre) -> wheel angle, positive left [rad]
SteeringFunction = Callable[[Course, VehicleState, float], float]


@dataclass(frozen=True)
class Method:
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
    """Return the five methods of the paper, then those of this project.

    Args:
        car: the car
        axles: the axles as the controllers know them
        config: parameters of config/simple_controller.yaml
    """
    lf, lr, wheelbase = car.front_axle_m, car.rear_axle_m, car.wheelbase_m
    gyration_m = math.sqrt(car.yaw_inertia_kgm2 / car.mass_kg)
    tyres = {"gyration_m": gyration_m, "tick_s": _TICK_S, "preview_s": 0.0}
    lqr = LqrSteering(axles, **LQR_WEIGHTS, **tyres)
    feedforward = LqrFeedforwardSteering(axles, **LQR_WEIGHTS, **tyres)
    paper = [
        Method(
            "pure pursuit", -lr, _TICK_S, lambda: functools.partial(_pure_pursuit, lr, wheelbase)
        ),
        Method("Stanley", lf, _TICK_S, lambda: functools.partial(_stanley, lf)),
        Method("kinematic", -lr, _TICK_S, lambda: _kinematic(lr, wheelbase)),
        Method("LQR", 0.0, _TICK_S, lambda: functools.partial(_state_feedback, lqr)),
        Method("LQR+FF", 0.0, _TICK_S, lambda: functools.partial(_state_feedback, feedforward)),
    ]
    own = [
        Method(own_name(name), 0.0, _OWN_TICK_S, functools.partial(_own, name, axles, config))
        for name in OWN_METHODS
    ]
    return [*paper, *own]


def point_of(state: VehicleState, ahead_m: float) -> tuple[float, float]:
    """Return the point of the car that is `ahead_m` ahead of its centre of gravity [m]."""
    return (
        state.x_m + ahead_m * math.cos(state.yaw_rad),
        state.y_m + ahead_m * math.sin(state.yaw_rad),
    )


def _pure_pursuit(
    rear_m: float, wheelbase_m: float, course: Course, state: VehicleState, near_s_m: float
) -> float:
    """Steer the rear axle to the point of the road at the look-ahead distance."""
    x, y = point_of(state, -rear_m)
    look_ahead = PURE_PURSUIT_S * state.speed_mps
    s = course.place(x, y, near_s_m - rear_m).s_m + look_ahead
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


def _stanley(front_m: float, course: Course, state: VehicleState, near_s_m: float) -> float:
    """Steer the front axle with Stanley's law."""
    place = course.place(*point_of(state, front_m), near_s_m + front_m)
    heading_error = wrap_angle(place.heading_rad - state.yaw_rad)
    return stanley_angle(heading_error, place.cross_track_m, state.speed_mps, STANLEY_PER_S)


def _kinematic(rear_m: float, wheelbase_m: float) -> SteeringFunction:
    """Return the kinematic controller at the rear axle, which has a state."""
    form = ChainedForm(wheelbase_m)

    def steer(course: Course, state: VehicleState, near_s_m: float) -> float:
        place = course.place(*point_of(state, -rear_m), near_s_m - rear_m)
        change = course.curvature_at(place.s_m + 0.1) - course.curvature_at(place.s_m - 0.1)
        return form.wheel_angle(
            state.speed_mps * _TICK_S,
            place.cross_track_m,
            wrap_angle(state.yaw_rad - place.heading_rad),
            course.curvature_at(place.s_m),
            change / 0.2,
            KINEMATIC_PER_M,
        )

    return steer


def _state_feedback(
    law: LqrSteering, course: Course, state: VehicleState, near_s_m: float
) -> float:
    """Steer the centre of gravity with the full state of the car."""
    place = course.place(state.x_m, state.y_m, near_s_m)
    curvature = course.curvature_at(place.s_m)
    error = wrap_angle(state.yaw_rad - place.heading_rad)
    return law.feedback(
        place.cross_track_m,
        state.speed_mps * math.sin(error) + state.lateral_speed_mps * math.cos(error),
        error,
        state.yaw_rate_radps - state.speed_mps * curvature,
        curvature,
        state.speed_mps,
    )


def _own(name: str, axles: Axles, config: Mapping[str, Any]) -> SteeringFunction:
    """Return a method of this project, which follows points as the local planner publishes them."""
    steering = load_steering(name, config[name], axles)
    path = ReferencePath()

    def steer(course: Course, state: VehicleState, near_s_m: float) -> float:
        first = math.ceil(course.place(state.x_m, state.y_m, near_s_m).s_m / _OWN_STEP_M)
        steps = int(_OWN_LOOK_AHEAD_M / _OWN_STEP_M)
        path.update(
            [
                (*course.line.point_at(i * _OWN_STEP_M), state.speed_mps)
                for i in range(first, first + steps + 1)
            ]
        )
        return steering.wheel_angle(
            path, state.x_m, state.y_m, state.yaw_rad, state.speed_mps, state.yaw_rate_radps
        )

    return steer
