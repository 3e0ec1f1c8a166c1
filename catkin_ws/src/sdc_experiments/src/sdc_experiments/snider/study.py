"""The courses of Snider's comparison of steering methods, driven with his car: python3 -m sdc_experiments.snider [FOLDER]

Drives every method of the paper in the paper's own form, and this project's default. The report on it, controllers.md with its
pictures, goes into FOLDER (docs/ of this project where none is named); `snider_report` writes it. No ROS, no clock: two runs
write the same figures.

Source: J. M. Snider, Automatic Steering Methods for Autonomous Automobile Path Tracking, CMU-RI-TR-09-08, 2009.
"""

from __future__ import annotations

import math
import os
from bisect import bisect_left
from dataclasses import dataclass, replace

import numpy as np
import yaml
from scipy.optimize import brentq
from scipy.special import j0

from sdc_common.geometry.angles import wrap_angle
from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles
from sdc_package.steering.kinematic import ChainedForm
from sdc_package.steering.lqr import LqrFeedforwardSteering, LqrSteering
from sdc_package.steering.method import load_steering
from sdc_package.steering.pure_pursuit import pure_pursuit_angle
from sdc_package.steering.stanley import stanley_angle
from sdc_sim.physics.vehicle import Vehicle, VehicleCommand, VehicleParameters, load_vehicle

SPEEDS_MPS = (5.0, 10.0, 15.0, 20.0)

# The paper's peak errors in metres as read from its plots, approximate, at SPEEDS_MPS; None where it shows none.
PAPER_M = {
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

# Stanley's gain is the paper's. The others were not at hand: each is the one value that comes nearest to the paper's errors.
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

_TICK_S = 0.01
_OUR_TICK_S = 0.05
_OUR_LOOK_AHEAD_M = 25.0
_OUR_STEP_M = 1.0
_SAMPLE_M = 0.05
_LOST_M = 10.0
_MOST_STEPS = 6
_CLOSE_ENOUGH_M = 0.01


class Course:
    """A road known at every 5 cm: arc length, x, y, heading and curvature (lists, metres and radians). `measured` are the stretches
    of arc length over which errors count."""

    def __init__(self, name: str, curvature_at, length_m: float, measured):
        count = int(round(length_m / _SAMPLE_M)) + 1
        s = np.arange(count) * _SAMPLE_M
        middle = np.array([curvature_at(value) for value in s[:-1] + 0.5 * _SAMPLE_M])
        heading = np.concatenate([[0.0], np.cumsum(middle) * _SAMPLE_M])
        direction = heading[:-1] + 0.5 * middle * _SAMPLE_M
        self.name = name
        self.length_m = float(s[-1])
        self.x = np.concatenate([[0.0], np.cumsum(np.cos(direction)) * _SAMPLE_M]).tolist()
        self.y = np.concatenate([[0.0], np.cumsum(np.sin(direction)) * _SAMPLE_M]).tolist()
        self.heading = heading.tolist()
        self.curvature = [curvature_at(value) for value in s.tolist()]
        self.measured = measured

    def place(self, x_m: float, y_m: float, near_s_m: float):
        """(arc length, cross-track error, heading, curvature) of the place nearest to a point, searched from `near_s_m`. The error is
        positive to the left."""
        s = near_s_m
        for _ in range(_MOST_STEPS):
            x, y, heading, curvature = self.at(s)
            cos, sin = math.cos(heading), math.sin(heading)
            along = (x_m - x) * cos + (y_m - y) * sin
            side = (y_m - y) * cos - (x_m - x) * sin
            s += along / max(0.2, 1.0 - curvature * side)
            if abs(along) < _CLOSE_ENOUGH_M:
                break
        return s, side, heading, curvature

    def at(self, s_m: float):
        """(x, y, heading, curvature) at an arc length; beyond its ends the road goes straight on."""
        i = min(max(int(s_m / _SAMPLE_M), 0), len(self.x) - 2)
        part = s_m / _SAMPLE_M - i
        inside = min(max(part, 0.0), 1.0)
        return (
            self.x[i] + part * (self.x[i + 1] - self.x[i]),
            self.y[i] + part * (self.y[i + 1] - self.y[i]),
            self.heading[i] + inside * (self.heading[i + 1] - self.heading[i]),
            self.curvature[i] + inside * (self.curvature[i + 1] - self.curvature[i]),
        )

    def is_measured(self, s_m: float) -> bool:
        """Whether errors count here."""
        return any(start <= s_m <= end for start, end in self.measured)


def curvature_of(pieces):
    """A function of arc length from (length, curvature at its end) pieces; curvature is linear along a piece and begins with 0."""
    ends, values = [0.0], [0.0]
    for length, curvature in pieces:
        ends.append(ends[-1] + length)
        values.append(curvature)

    def curvature_at(s):
        if s >= ends[-1]:
            return values[-1]
        i = max(0, bisect_left(ends, s) - 1)
        return values[i] + (s - ends[i]) / (ends[i + 1] - ends[i]) * (values[i + 1] - values[i])

    return curvature_at, ends


def lane_change() -> Course:
    """To the left by 3.5 m, 25 m on, and back. Each change is one period of a sine of curvature, which neither jumps nor has a corner,
    over 30 m: 99 % of the way to the side lie within 25 m, the length that one reads from the paper's plot."""
    width, length, gap = 3.5, 30.0, 25.0
    # Curvature a sin(2 pi s / T) turns by h (1 - cos(2 pi s / T)) with h = a T / (2 pi), and moves the car sideways by T sin(h) J0(h).
    mean_heading = brentq(lambda h: length * math.sin(h) * j0(h) - width, 0.0, 0.5)
    peak = 2.0 * math.pi / length * mean_heading

    def curvature_at(s):
        for start, side in ((30.0, 1.0), (30.0 + length + gap, -1.0)):
            if start <= s <= start + length:
                return side * peak * math.sin(2.0 * math.pi * (s - start) / length)
        return 0.0

    return Course("lane change", curvature_at, 180.0, [(20.0, 160.0)])


def figure_eight() -> Course:
    """Three quarters of a circle of 64 m radius to the left, across, and as much to the right; only the later half of each counts,
    where the car has settled."""
    circle = 64.0 * 1.5 * math.pi
    pieces = [
        (30.0, 0.0),
        (40.0, 1.0 / 64.0),
        (circle, 1.0 / 64.0),
        (80.0, -1.0 / 64.0),
        (circle, -1.0 / 64.0),
        (40.0, 0.0),
    ]
    curvature_at, ends = curvature_of(pieces)
    return Course(
        "figure-eight",
        curvature_at,
        ends[-1],
        [(ends[2] + 0.5 * circle, ends[3]), (ends[4] + 0.5 * circle, ends[5])],
    )


def road_course() -> Course:
    """Eight bends of 60 to 200 m radius on 1.3 km of country road. The paper drove a road of its own, which is not published."""
    pieces = [(40.0, 0.0)]
    for radius, angle, straight in (
        (80.0, 70.0, 30.0),
        (-60.0, 90.0, 0.0),
        (70.0, 60.0, 50.0),
        (200.0, 40.0, 0.0),
        (-100.0, 80.0, 20.0),
        (-65.0, 45.0, 0.0),
        (60.0, 100.0, 40.0),
        (-150.0, 50.0, 0.0),
    ):
        entry = 25.0
        arc = abs(radius) * math.radians(angle) - entry
        pieces += [(entry, 1.0 / radius), (arc, 1.0 / radius), (entry, 0.0)]
        pieces += [(straight, 0.0)] if straight else []
    pieces.append((60.0, 0.0))
    curvature_at, ends = curvature_of(pieces)
    return Course("road course", curvature_at, ends[-1], [(20.0, ends[-1] - 30.0)])


@dataclass(frozen=True)
class Method:
    """A way of steering: the point ahead of the centre of gravity (metres) whose error it is about and which is measured, the time
    between two of its commands, and `build()`, which gives a fresh function (course, vehicle state, near_s_m) -> wheel angle."""

    name: str
    point_m: float
    tick_s: float
    build: object


def methods(car: VehicleParameters, axles: Axles, config: dict):
    """The five methods of the paper, then this project's default."""
    lf, lr, wheelbase = car.front_axle_m, car.rear_axle_m, car.wheelbase_m
    tyres = {
        "gyration_m": math.sqrt(car.yaw_inertia_kgm2 / car.mass_kg),
        "tick_s": _TICK_S,
        "preview_s": 0.0,
    }

    def pure_pursuit():
        def steer(course, state, near):
            x, y = point_of(state, -lr)
            look_ahead = PURE_PURSUIT_S * state.speed_mps
            s = course.place(x, y, near)[0] + look_ahead
            # The place on the road at that distance: a few steps of Newton's method.
            for _ in range(3):
                goal_x, goal_y, heading, _ = course.at(s)
                distance = math.hypot(goal_x - x, goal_y - y)
                slope = (
                    (goal_x - x) * math.cos(heading) + (goal_y - y) * math.sin(heading)
                ) / distance
                s += (look_ahead - distance) / max(0.3, slope)
            goal_x, goal_y, _, _ = course.at(s)
            return pure_pursuit_angle(
                math.atan2(goal_y - y, goal_x - x) - state.yaw_rad, look_ahead, wheelbase
            )

        return steer

    def stanley():
        def steer(course, state, near):
            _, cross_track, heading, _ = course.place(*point_of(state, lf), near)
            return stanley_angle(
                wrap_angle(heading - state.yaw_rad), cross_track, state.speed_mps, STANLEY_PER_S
            )

        return steer

    def kinematic():
        form = ChainedForm(wheelbase)

        def steer(course, state, near):
            s, cross_track, heading, curvature = course.place(*point_of(state, -lr), near)
            slope = (course.at(s + 0.1)[3] - course.at(s - 0.1)[3]) / 0.2
            return form.wheel_angle(
                state.speed_mps * _TICK_S,
                cross_track,
                wrap_angle(state.yaw_rad - heading),
                curvature,
                slope,
                KINEMATIC_PER_M,
            )

        return steer

    def optimal(method_class):
        law = method_class(axles, **LQR_WEIGHTS, **tyres)

        def steer(course, state, near):
            _, cross_track, heading, curvature = course.place(state.x_m, state.y_m, near)
            error = wrap_angle(state.yaw_rad - heading)
            rate = state.speed_mps * math.sin(error) + state.lateral_speed_mps * math.cos(error)
            return law.feedback(
                cross_track,
                rate,
                error,
                state.yaw_rate_radps - state.speed_mps * curvature,
                curvature,
                state.speed_mps,
            )

        return lambda: steer

    def ours():
        method = config["steering_method"]
        steering = load_steering(method, config[method], axles)
        path = ReferencePath()

        def steer(course, state, near):
            first = math.ceil(course.place(state.x_m, state.y_m, near)[0] / _OUR_STEP_M)
            steps = int(_OUR_LOOK_AHEAD_M / _OUR_STEP_M)
            path.update(
                [
                    (*course.at(i * _OUR_STEP_M)[:2], state.speed_mps)
                    for i in range(first, first + steps + 1)
                ]
            )
            return steering.wheel_angle(
                path, state.x_m, state.y_m, state.yaw_rad, state.speed_mps, state.yaw_rate_radps
            )

        return steer

    return [
        Method("pure pursuit", -lr, _TICK_S, pure_pursuit),
        Method("Stanley", lf, _TICK_S, stanley),
        Method("kinematic", -lr, _TICK_S, kinematic),
        Method("LQR", 0.0, _TICK_S, optimal(LqrSteering)),
        Method("LQR+FF", 0.0, _TICK_S, optimal(LqrFeedforwardSteering)),
        Method("this project", 0.0, _OUR_TICK_S, ours),
    ]


def point_of(state, ahead_m: float):
    """(x, y) of the point of the car that lies `ahead_m` ahead of its centre of gravity."""
    return state.x_m + ahead_m * math.cos(state.yaw_rad), state.y_m + ahead_m * math.sin(
        state.yaw_rad
    )


@dataclass(frozen=True)
class Trace:
    """A drive: arc length of the method's point, its cross-track error and that of the centre (N,) metres, x and y of the centre, and
    whether the car stayed within 10 m of the road until its end. `peak_m` and `centre_peak_m` are the largest errors that count."""

    s_m: np.ndarray
    error_m: np.ndarray
    centre_error_m: np.ndarray
    xy_m: np.ndarray
    finished: bool
    peak_m: float
    centre_peak_m: float


def drive(method: Method, course: Course, speed_mps: float, car: VehicleParameters) -> Trace:
    """Drive a course from end to end at one speed."""
    vehicle = Vehicle(car)
    x, y, heading, _ = course.at(5.0)
    vehicle.reset(x, y, heading, speed_mps)
    steer = method.build()
    near, integral, rows, counts = 5.0, 0.0, [], []
    finished = False
    for _ in range(int(1.3 * course.length_m / speed_mps / method.tick_s)):
        state = vehicle.state
        near, centre_error, _, _ = course.place(state.x_m, state.y_m, near)
        s, error, _, _ = course.place(*point_of(state, method.point_m), near)
        rows.append((s, error, centre_error, state.x_m, state.y_m))
        counts.append(course.is_measured(near))
        if near > course.length_m - 5.0:
            finished = True
            break
        if abs(centre_error) > _LOST_M:
            break
        wheel = steer(course, state, near)
        lag = speed_mps - state.speed_mps
        integral += 0.2 * lag * method.tick_s
        pedal = 0.5 * lag + integral
        vehicle.step(
            VehicleCommand(
                throttle=min(max(pedal, 0.0), 1.0),
                brake=min(max(-pedal, 0.0), 1.0),
                steer=min(max(-wheel / car.full_wheel_angle_rad(state.speed_mps), -1.0), 1.0),
            ),
            method.tick_s,
        )
    table = np.array(rows)
    counted = (
        np.abs(table[np.array(counts, dtype=bool), 1:3])
        if any(counts)
        else np.full((1, 2), math.inf)
    )
    peak, centre_peak = counted.max(axis=0).tolist() if finished else (math.inf, math.inf)
    return Trace(table[:, 0], table[:, 1], table[:, 2], table[:, 3:], finished, peak, centre_peak)


def snider_car():
    """(the car of the paper, its axles with the compliances of its tyres)."""
    folder = os.path.join(_packages(), "sdc_sim", "config", "vehicles")
    car = load_vehicle(os.path.join(folder, "snider2009.yaml"))
    front_load = car.mass_kg * car.rear_axle_m / car.wheelbase_m
    rear_load = car.mass_kg - front_load
    return car, Axles(
        car.front_axle_m,
        car.rear_axle_m,
        front_load / car.front_cornering_stiffness_n_per_rad,
        rear_load / car.rear_cornering_stiffness_n_per_rad,
    )


# Wheel angle a unit of lateral acceleration, rad/(m/s^2), that the paper's simulated car seems to need and its bicycle does not know.
UNDERSTEER = 0.0015


def understeering(car: VehicleParameters, gradient: float = UNDERSTEER) -> VehicleParameters:
    """The same car with a front axle that gives more, so that its understeer gradient grows by `gradient`, rad/(m/s^2)."""
    front_load = car.mass_kg * car.rear_axle_m / car.wheelbase_m
    stiffness = front_load / (front_load / car.front_cornering_stiffness_n_per_rad + gradient)
    return replace(car, front_cornering_stiffness_n_per_rad=stiffness)


def controller_config() -> dict:
    """config/simple_controller.yaml of sdc_package."""
    with open(
        os.path.join(_packages(), "sdc_package", "config", "simple_controller.yaml"),
        encoding="utf-8",
    ) as file:
        return yaml.safe_load(file)


def all_drives(cars, courses, speeds_mps=SPEEDS_MPS) -> dict:
    """Every method of every car of the mapping `cars` on every course at every speed: {(car, course, method, speed): Trace}."""
    _, axles = snider_car()
    config = controller_config()
    traces = {}
    for name, car in cars.items():
        for method in methods(car, axles, config):
            for course in courses:
                for speed in speeds_mps:
                    traces[name, course.name, method.name, speed] = drive(
                        method, course, speed, car
                    )
    return traces


def _packages() -> str:
    """The folder with both packages: where the sources are, or the share folder of an install space."""
    here = os.path.dirname(os.path.abspath(__file__))
    sources = os.path.abspath(os.path.join(here, "..", "..", ".."))
    if os.path.isdir(os.path.join(sources, "sdc_sim", "config")):
        return sources
    import rospkg

    return os.path.dirname(rospkg.RosPack().get_path("sdc_sim"))


if __name__ == "__main__":
    from sdc_experiments import snider_report

    snider_report.main()
