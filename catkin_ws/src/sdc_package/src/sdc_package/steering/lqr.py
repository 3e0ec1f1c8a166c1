"""LQR steering: optimal state feedback on the dynamic bicycle model, with and without feed-forward.

Reference: R. Rajamani, Vehicle Dynamics and Control, 2nd ed., section 2.5 (the bicycle model in
terms of its errors), section 3.1 (state feedback) and section 3.2 (steady-state errors, and the
feed-forward that removes the cross-track error). These are the optimal controllers of J. M. Snider,
CMU-RI-TR-09-08, 2009. The gains are those of the sampled system, because a wheel angle holds for
one tick.
"""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from sdc_common.geometry.angles import wrap_angle
from sdc_common.validation import check_non_negative, check_positive
from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import MAX_SLIP_SINE, Axles
from sdc_package.steering.method import Steering, predicted_pose

# Below the first speed the tyres of the model are too stiff for a solution; no car drives faster
# than the last one.
_SPEEDS_MPS = [1.0 + 0.5 * i for i in range(79)]


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


def calmed(steer_weight: float, speed_mps: float, calm_above_mps: float) -> float:
    """Return the cost of the wheel angle at a speed.

    The lateral acceleration of a wheel angle grows with the square of the speed, and the model
    knows neither the delay of the steering nor the true lateral speed. With a constant cost of the
    wheel angle, the car of this project swings from 25 m/s on. Above `calm_above_mps` the cost
    therefore grows with the fourth power of the speed, as the square of that acceleration does.
    """
    return steer_weight * max(1.0, speed_mps / calm_above_mps) ** 4


class GainSchedule:
    """Gains over speed, linear between the given speeds and constant beyond."""

    def __init__(self, speeds_mps: Sequence[float], rows: Sequence[Sequence[float]]):
        """Set the gains.

        Args:
            speeds_mps: two or more equidistant speeds, rising [m/s]
            rows: gains at each speed
        """
        self.first_mps = speeds_mps[0]
        self.step_mps = speeds_mps[1] - speeds_mps[0]
        self.rows = rows

    def gains(self, speed_mps: float) -> list[float]:
        """Return the gains at this speed."""
        position = (speed_mps - self.first_mps) / self.step_mps
        position = min(max(position, 0.0), len(self.rows) - 1.0)
        low = min(int(position), len(self.rows) - 2)
        fraction = position - low
        return [a + fraction * (b - a) for a, b in zip(self.rows[low], self.rows[low + 1])]


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
    slip = math.asin(sine)
    acceleration = curvature * speed_mps * speed_mps
    wheel = (
        math.atan(axles.wheelbase_m / axles.rear_m * math.tan(slip))
        + axles.understeer_gradient * acceleration
    )
    return wheel, -slip + axles.rear_compliance * acceleration


class LqrSteering(Steering):
    """State feedback at the car's centre without feed-forward; in a bend a steady error remains."""

    feeds_forward = False

    def __init__(
        self,
        axles: Axles,
        cross_track_weight: float,
        cross_track_rate_weight: float,
        heading_weight: float,
        heading_rate_weight: float,
        steer_weight: float,
        gyration_m: float,
        tick_s: float,
        preview_s: float,
        calm_above_mps: float = math.inf,
    ):
        """Compute the gains over speed.

        Args:
            axles: geometry and tyres of the car
            cross_track_weight: cost of the cross-track error [1/m^2]
            cross_track_rate_weight: cost of its rate [s^2/m^2]
            heading_weight: cost of the heading error [1/rad^2]
            heading_rate_weight: cost of its rate [s^2/rad^2]
            steer_weight: cost of the wheel angle [1/rad^2]
            gyration_m: radius of gyration about the vertical axis [m]
            tick_s: time for which a command holds [s]
            preview_s: delay over which the pose is predicted [s]
            calm_above_mps: speed above which the wheel angle costs more, see `calmed` [m/s]
        """
        check_positive(
            cross_track_weight=cross_track_weight,
            steer_weight=steer_weight,
            gyration_m=gyration_m,
            tick_s=tick_s,
        )
        if not calm_above_mps > 0.0:
            raise ValueError(f"'calm_above_mps' must be positive, got {calm_above_mps}")
        check_non_negative(
            cross_track_rate_weight=cross_track_rate_weight,
            heading_weight=heading_weight,
            heading_rate_weight=heading_rate_weight,
            preview_s=preview_s,
        )
        if not (axles.front_compliance > 0.0 and axles.rear_compliance > 0.0):
            raise ValueError(
                "the dynamic bicycle model needs slipping tyres: set 'front_compliance' and "
                "'rear_compliance' of 'axles' above 0"
            )
        self.axles = axles
        self.preview_s = preview_s
        weights = cross_track_weight, cross_track_rate_weight, heading_weight, heading_rate_weight
        self.schedule = GainSchedule(
            _SPEEDS_MPS,
            [
                lqr_gains(
                    v, axles, gyration_m, weights, calmed(steer_weight, v, calm_above_mps), tick_s
                )
                for v in _SPEEDS_MPS
            ],
        )

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
        return self.feedback(
            place.cross_track_m,
            rate,
            heading_error,
            yaw_rate_radps - speed_mps * curvature,
            curvature,
            speed_mps,
        )

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
        k1, k2, k3, k4 = self.schedule.gains(speed_mps)
        angle = (
            -k1 * cross_track_m
            - k2 * cross_track_rate_mps
            - k3 * heading_error_rad
            - k4 * heading_rate_radps
        )
        if self.feeds_forward:
            wheel, heading_error = steady_state(curvature, speed_mps, self.axles)
            angle += wheel + k3 * heading_error
        return angle


class LqrFeedforwardSteering(LqrSteering):
    """LQR steering with the wheel angle of the bend as feed-forward: no error on a circle."""

    feeds_forward = True
