"""The drives of the comparison: every method with every car on every course at every speed.

There is no ROS and no clock: equal calls give equal numbers.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Iterable, Mapping, NamedTuple

from sdc_common.driving import Command
from sdc_experiments.configuration import node_parameters, vehicle_preset
from sdc_experiments.snider.courses import Course
from sdc_experiments.snider.methods import Method, all_methods, point_of
from sdc_package.steering.axles import Axles
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.physics.vehicle_parameters import VehicleParameters

# The cars of the study.
NEUTRAL, UNDERSTEERING = "neutral", "understeering"

SPEEDS_MPS = (5.0, 10.0, 15.0, 20.0)

# Peak errors of the paper at SPEEDS_MPS [m], read from its plots, approximate; None where it shows
# none.
PAPER_M: dict[str, dict[str, tuple[float | None, ...]]] = {
    "lane change": {
        "pure pursuit": (0.01, 0.07, 0.26, None),
        "Stanley": (0.007, 0.05, 0.16, None),
        "kinematic": (None, 0.10, 0.29, None),
        "LQR": (0.06, 0.08, 0.16, None),
        "LQR+FF": (0.02, None, None, None),
    },
    "figure-eight": {
        "pure pursuit": (0.004, 0.037, 0.15, 0.47),
        "Stanley": (0.0045, 0.04, 0.145, 0.4),
        "kinematic": (0.015, 0.06, 0.15, 0.3),
        "LQR": (0.044, 0.057, 0.09, 0.15),
        "LQR+FF": (0.001, 0.008, 0.02, 0.05),
    },
}

# Wheel angle per lateral acceleration that the paper's simulated car seems to need and its bicycle
# model does not contain [rad/(m/s^2)].
UNDERSTEER = 0.0015

_START_S_M = 5.0
_END_BEFORE_M = 5.0
_MAX_OFFSET_M = 10.0
_MAX_TIME_RATIO = 1.3
# The speed controller: proportional and integral gain from m/s to pedal.
_SPEED_KP = 0.5
_SPEED_KI = 0.2


class PeakErrors(NamedTuple):
    """The largest measured cross-track errors of a drive.

    They are infinite where the car did not stay within 10 m of the road until its end.
    """

    point_m: float  # of the method's point [m]
    centre_m: float  # of the car's centre [m]


# By name of the car, name of the course, name of the method, speed [m/s].
Peaks = Mapping[tuple, PeakErrors]


def drive(method: Method, course: Course, speed_mps: float, car: VehicleParameters) -> PeakErrors:
    """Drive a course from start to end at a constant speed [m/s]."""
    vehicle, steer = Vehicle(car), method.build()
    start_x, start_y = course.line.point_at(_START_S_M)
    vehicle.reset(start_x, start_y, course.line.heading_at(_START_S_M), speed_mps)
    near, integral, point_m, centre_m = _START_S_M, 0.0, 0.0, 0.0
    for _ in range(int(_MAX_TIME_RATIO * course.length_m / speed_mps / method.tick_s)):
        state = vehicle.state
        centre = course.place(state.x_m, state.y_m, near)
        near = centre.s_m
        point = course.place(*point_of(state, method.point_m), near + method.point_m)
        if any(start <= near <= end for start, end in course.measured):
            point_m = max(point_m, abs(point.cross_track_m))
            centre_m = max(centre_m, abs(centre.cross_track_m))
        if near > course.length_m - _END_BEFORE_M:
            return PeakErrors(point_m, centre_m)
        if centre.distance_m > _MAX_OFFSET_M:
            break
        speed_error = speed_mps - state.speed_mps
        integral += _SPEED_KI * speed_error * method.tick_s
        pedal = _SPEED_KP * speed_error + integral
        steering = -steer(course, state, point) / car.full_wheel_angle_rad(state.speed_mps)
        # The vehicle limits the command.
        vehicle.step(Command(max(pedal, 0.0), steering, max(-pedal, 0.0)), method.tick_s)
    return PeakErrors(math.inf, math.inf)


def snider_car() -> tuple[VehicleParameters, Axles]:
    """Return the car of the paper, and its axles with the compliances of its tyres."""
    car = vehicle_preset("snider2009")
    front_load = car.mass_kg * car.rear_axle_m / car.wheelbase_m
    rear_load = car.mass_kg - front_load
    return car, Axles(
        car.front_axle_m,
        car.rear_axle_m,
        front_load / car.front_cornering_stiffness_n_per_rad,
        rear_load / car.rear_cornering_stiffness_n_per_rad,
    )


def understeering(car: VehicleParameters) -> VehicleParameters:
    """Return the same car with a softer front axle: its understeer gradient is UNDERSTEER more."""
    front_load = car.mass_kg * car.rear_axle_m / car.wheelbase_m
    stiffness = front_load / (front_load / car.front_cornering_stiffness_n_per_rad + UNDERSTEER)
    return replace(car, front_cornering_stiffness_n_per_rad=stiffness)


def all_drives(
    cars: Mapping[str, VehicleParameters],
    courses: Iterable[Course],
    speeds_mps: Iterable[float] = SPEEDS_MPS,
) -> Peaks:
    """Drive every method with every car on every course at every speed.

    Returns:
        peak errors of each (name of the car, name of the course, name of the method, speed)
    """
    courses, speeds = list(courses), list(speeds_mps)
    _, axles = snider_car()
    config = node_parameters("simple_controller")
    return {
        (name, course.name, method.name, speed): drive(method, course, speed, car)
        for name, car in cars.items()
        for method in all_methods(car, axles, config)
        for course in courses
        for speed in speeds
    }
