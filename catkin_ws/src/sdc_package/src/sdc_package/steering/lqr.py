"""LQR steering: optimal state feedback on the dynamic bicycle model, with and without feed-forward.

Reference: R. Rajamani, Vehicle Dynamics and Control, 2nd ed., section 2.5 (the bicycle model in
terms of its errors), section 3.1 (state feedback) and section 3.2 (steady-state errors, and the
feed-forward that removes the cross-track error). These are the optimal controllers of J. M. Snider,
CMU-RI-TR-09-08, 2009. The gains are those of the sampled system, because a wheel angle holds for
one tick.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Sequence

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from sdc_common.geometry.angles import wrap_angle
from sdc_common.validation import check_non_negative, check_positive
from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import MAX_SLIP_SINE, Axles
from sdc_package.steering.method import Steering, predicted_pose

# Below the first speed the tyres of the model are too stiff for a solution; no car drives faster
# than the last one.
_SPEEDS_MPS = np.arange(1.0, 40.5, 0.5)


def error_model(speed_mps: float, axles: Axles, gyration_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the continuous error dynamics x' = A x + B delta on a straight path.

    The state x is [cross-track error m, its rate m/s, heading error rad, its rate rad/s], positive
    left. Divided by the mass, the cornering stiffness of an axle is its share of the weight over
    its compliance.

    Args:
        speed_mps: speed [m/s]
        axles: geometry and tyres of the car
        gyration_m: radius of gyration about the vertical axis, sqrt(yaw inertia / mass) [m]

    Returns:
        A (4, 4) and B (4, 1)

    Reference: Rajamani, equation 2.45.
    """
    lf, lr = axles.front_m, axles.rear_m
    front = lr / (axles.wheelbase_m * axles.front_compliance)
    rear = lf / (axles.wheelbase_m * axles.rear_compliance)
    inertia = gyration_m * gyration_m
    turn = lf * front - lr * rear
    damping = lf * lf * front + lr * lr * rear
    v = speed_mps
    a = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [0.0, -(front + rear) / v, front + rear, -turn / v],
            [0.0, 0.0, 0.0, 1.0],
            [0.0, -turn / (inertia * v), turn / inertia, -damping / (inertia * v)],
        ]
    )
    b = np.array([[0.0], [front], [0.0], [lf * front / inertia]])
    return a, b


def lqr_gains(
    speed_mps: float,
    axles: Axles,
    gyration_m: float,
    weights: Sequence[float],
    steer_weight: float,
    tick_s: float,
) -> list[float]:
    """Return the four gains K of delta = -K x at one speed [rad per unit of each error].

    Args:
        speed_mps: speed [m/s]
        axles: geometry and tyres of the car
        gyration_m: radius of gyration about the vertical axis [m]
        weights: (4,) cost per square of each error
        steer_weight: cost per square of the wheel angle
        tick_s: time for which a wheel angle holds [s]

    Raises:
        ValueError: no gains stabilize this car
    """
    a, b = error_model(speed_mps, axles, gyration_m)
    held = expm(tick_s * np.block([[a, b], [np.zeros((1, 5))]]))
    a, b = held[:4, :4], held[:4, 4:]
    try:
        p = solve_discrete_are(a, b, np.diag(weights), np.array([[steer_weight]]))
        return np.linalg.solve(steer_weight + b.T @ p @ b, b.T @ p @ a)[0].tolist()
    except np.linalg.LinAlgError as error:
        raise ValueError(
            f"no gains stabilize this car at {speed_mps:g} m/s ({error}); check its weights and "
            "axles"
        ) from error


def steady_state(curvature: float, speed_mps: float, axles: Axles) -> tuple[float, float]:
    """Return wheel angle and heading error of a car on a circle, with its centre on the path [rad].

    For small angles they are L c + K v^2 c and -rear c + rear compliance v^2 c (Rajamani, equations
    3.12 and 3.13 with compliances). Tight bends need the exact geometry of the bicycle, which is
    used here.

    Args:
        curvature: curvature of the circle, positive left [1/m]
        speed_mps: speed [m/s]
        axles: geometry and tyres of the car
    """
    sine = min(max(axles.rear_m * curvature, -MAX_SLIP_SINE), MAX_SLIP_SINE)
    slip, acceleration = math.asin(sine), curvature * speed_mps * speed_mps
    rolling = math.atan(axles.wheelbase_m / axles.rear_m * math.tan(slip))
    wheel = rolling + axles.understeer_gradient * acceleration
    return wheel, -slip + axles.rear_compliance * acceleration


@dataclass(eq=False)
class LqrSteering(Steering):
    """State feedback at the car's centre without feed-forward; in a bend a steady error remains."""

    feeds_forward: ClassVar[bool] = False

    axles: Axles  # geometry and tyres of the car
    cross_track_weight: float  # cost of the cross-track error [1/m^2]
    cross_track_rate_weight: float  # cost of its rate [s^2/m^2]
    heading_weight: float  # cost of the heading error [1/rad^2]
    heading_rate_weight: float  # cost of its rate [s^2/rad^2]
    steer_weight: float  # cost of the wheel angle [1/rad^2]
    gyration_m: float  # radius of gyration about the vertical axis [m]
    tick_s: float  # time for which a command holds [s]
    preview_s: float  # delay over which the pose is predicted [s]
    # The lateral acceleration of a wheel angle grows with the square of the speed, and the model
    # knows neither the delay of the steering nor the true lateral speed. With a constant cost of
    # the wheel angle, the car of this project swings from 25 m/s on. Above this speed [m/s] the
    # cost therefore grows with the fourth power, as the square of that acceleration does.
    calm_above_mps: float = math.inf

    def __post_init__(self):
        numbers = dict(vars(self))
        axles, calm_above_mps = numbers.pop("axles"), numbers.pop("calm_above_mps")
        if not calm_above_mps > 0.0:
            raise ValueError(f"'calm_above_mps' must be positive, got {calm_above_mps}")
        positive = "cross_track_weight", "steer_weight", "gyration_m", "tick_s"
        check_positive(**{name: numbers.pop(name) for name in positive})
        check_non_negative(**numbers)
        if not (axles.front_compliance > 0.0 and axles.rear_compliance > 0.0):
            raise ValueError(
                "the dynamic bicycle model needs slipping tyres: set 'front_compliance' and "
                "'rear_compliance' of 'axles' above 0"
            )
        cross_track = self.cross_track_weight, self.cross_track_rate_weight
        weights = *cross_track, self.heading_weight, self.heading_rate_weight
        rows = []
        for v in _SPEEDS_MPS.tolist():
            steer_weight = self.steer_weight * max(1.0, v / calm_above_mps) ** 4
            rows.append(lqr_gains(v, axles, self.gyration_m, weights, steer_weight, self.tick_s))
        self._gains = np.transpose(rows)  # one row over the speeds for each error

    def wheel_angle(
        self,
        path: ReferencePath,
        x_m: float,
        y_m: float,
        yaw_rad: float,
        speed_mps: float,
        yaw_rate_radps: float = 0.0,
    ) -> float:
        """See Steering.wheel_angle."""
        x, y, yaw = predicted_pose(x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps, self.preview_s)
        place = path.line.nearest(x, y)
        curvature = path.line.curvature_at(place.s_m)
        heading_error = wrap_angle(yaw - place.heading_rad)
        # The lateral speed of the centre is not measured. It is taken from a steady bend.
        lever_m = self.axles.rear_m - self.axles.rear_compliance * speed_mps * speed_mps
        lateral_mps = lever_m * yaw_rate_radps
        rate = speed_mps * math.sin(heading_error) + lateral_mps * math.cos(heading_error)
        turning = yaw_rate_radps - speed_mps * curvature
        errors = place.cross_track_m, rate, heading_error, turning
        return self.feedback(*errors, curvature, speed_mps)

    def feedback(
        self,
        cross_track_m: float,
        cross_track_rate_mps: float,
        heading_error_rad: float,
        heading_rate_radps: float,
        curvature: float,
        speed_mps: float,
    ) -> float:
        """Return the front wheel angle for the errors of the car's centre, all positive left [rad].

        Args:
            cross_track_m: cross-track error [m]
            cross_track_rate_mps: its rate [m/s]
            heading_error_rad: heading of the car minus heading of the path [rad]
            heading_rate_radps: its rate [rad/s]
            curvature: curvature of the path [1/m]
            speed_mps: speed [m/s]
        """
        k1, k2, k3, k4 = (float(np.interp(speed_mps, _SPEEDS_MPS, k)) for k in self._gains)
        angle = -k1 * cross_track_m - k2 * cross_track_rate_mps
        angle = angle - k3 * heading_error_rad - k4 * heading_rate_radps
        if self.feeds_forward:
            wheel, heading_error = steady_state(curvature, speed_mps, self.axles)
            angle += wheel + k3 * heading_error
        return angle


class LqrFeedforwardSteering(LqrSteering):
    """LQR steering with the wheel angle of the bend as feed-forward: no error on a circle."""

    feeds_forward: ClassVar[bool] = True
