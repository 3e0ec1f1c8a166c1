"""LQR steering: state feedback on the dynamic bicycle's errors, optimal for a quadratic cost, with and without feed-forward.

Source: R. Rajamani, Vehicle Dynamics and Control, 2nd ed., section 2.5 (the bicycle in terms of its errors), section 3.1 (state feedback)
and section 3.2 (the steady-state errors, and the feed-forward that removes that of position); these are the optimal controllers of
J. M. Snider, CMU-RI-TR-09-08, 2009. The gains are those of the sampled system: a wheel angle holds for a tick.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from sdc_common.geometry.angles import wrap_angle
from sdc_common.validation import check_non_negative, check_positive
from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles
from sdc_package.steering.method import Steering, predicted_pose

# Below the first of these speeds the model's tyres are too stiff to tell anything, beyond the last one no road allows to drive.
_SPEEDS_MPS = [1.0 + 0.5 * i for i in range(79)]
_MOST_SLIP_SINE = 0.95


def error_model(speed_mps: float, axles: Axles, gyration_m: float):
    """The continuous error dynamics x' = A x + B delta (Rajamani, equation 2.45, without the road's own turning): A (4, 4), B (4, 1).

    x = [cross-track error m, its rate m/s, heading error rad, its rate rad/s], positive to the left; gyration_m is the
    radius of gyration about the vertical axis, sqrt(yaw inertia / mass). Divided by the mass, an axle's cornering stiffness is
    its share of the weight over its compliance.
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
    speed_mps: float, axles: Axles, gyration_m: float, weights, steer_weight: float, tick_s: float
):
    """The four gains K of delta = -K x at one speed, rad a unit of each error.

    weights: (4,) on the squares of the errors; steer_weight on that of the wheel angle; tick_s: for how long a wheel angle is held.
    Raises ValueError where these figures leave no stable car.
    """
    a, b = error_model(speed_mps, axles, gyration_m)
    held = expm(tick_s * np.block([[a, b], [np.zeros((1, 5))]]))
    a, b = held[:4, :4], held[:4, 4:]
    try:
        p = solve_discrete_are(a, b, np.diag(weights), np.array([[steer_weight]]))
        return np.linalg.solve(steer_weight + b.T @ p @ b, b.T @ p @ a)[0].tolist()
    except np.linalg.LinAlgError as error:
        raise ValueError(
            f"no gains keep such a car on its path at {speed_mps:g} m/s ({error})"
        ) from error


class GainSchedule:
    """LQR gains over speed, computed once; in between they are linear, beyond the ends constant. `gains(speed_mps)` gives four."""

    def __init__(self, speeds_mps, rows):
        self.first_mps = speeds_mps[0]
        self.step_mps = speeds_mps[1] - speeds_mps[0]
        self.rows = rows

    def gains(self, speed_mps: float):
        """[rad/m, rad/(m/s), rad/rad, rad/(rad/s)] at this speed."""
        place = min(max((speed_mps - self.first_mps) / self.step_mps, 0.0), len(self.rows) - 1.0)
        low = min(int(place), len(self.rows) - 2)
        part = place - low
        return [a + part * (b - a) for a, b in zip(self.rows[low], self.rows[low + 1])]


def steady_state(curvature: float, speed_mps: float, axles: Axles):
    """(wheel angle, heading error) in radians of the car that drives a circle with its centre on it.

    For small angles these are L c + K v^2 c and -rear c + rear compliance v^2 c (Rajamani, equations 3.12 and 3.13 rewritten with the
    compliances); here with the bicycle's exact geometry, which a bend of 4 m radius asks for.
    """
    sine = min(max(axles.rear_m * curvature, -_MOST_SLIP_SINE), _MOST_SLIP_SINE)
    slip = math.asin(sine)
    acceleration = curvature * speed_mps * speed_mps
    wheel = (
        math.atan(axles.wheelbase_m / axles.rear_m * math.tan(slip))
        + axles.understeer_gradient * acceleration
    )
    return wheel, -slip + axles.rear_compliance * acceleration


class LqrSteering(Steering):
    """State feedback at the car's centre, nothing else: in a bend it keeps an error that its gains leave.

    Figures: `cross_track_weight` 1/m^2, `cross_track_rate_weight` s^2/m^2, `heading_weight` 1/rad^2, `heading_rate_weight` s^2/rad^2 and
    `steer_weight` 1/rad^2 of the quadratic cost; `gyration_m`, the car's radius of gyration about the vertical axis; `tick_s`, for
    how long a command holds; `preview_s`, how far ahead in time the pose is predicted.
    """

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
    ):
        check_positive(
            cross_track_weight=cross_track_weight,
            steer_weight=steer_weight,
            gyration_m=gyration_m,
            tick_s=tick_s,
        )
        check_non_negative(
            cross_track_rate_weight=cross_track_rate_weight,
            heading_weight=heading_weight,
            heading_rate_weight=heading_rate_weight,
            preview_s=preview_s,
        )
        if not (axles.front_compliance > 0.0 and axles.rear_compliance > 0.0):
            raise ValueError(
                "the dynamic bicycle needs tyres that give: set front_compliance and rear_compliance of axles above 0"
            )
        self.axles = axles
        self.preview_s = preview_s
        weights = cross_track_weight, cross_track_rate_weight, heading_weight, heading_rate_weight
        self.schedule = GainSchedule(
            _SPEEDS_MPS,
            [
                lqr_gains(speed, axles, gyration_m, weights, steer_weight, tick_s)
                for speed in _SPEEDS_MPS
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
        """See Steering.wheel_angle. How fast the car slides at its centre is not measured: it is that of a steady bend."""
        x, y, yaw = predicted_pose(x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps, self.preview_s)
        _, _, s, cross_track, heading = path.line.nearest(x, y)
        curvature = path.line.curvature_at(s)
        heading_error = wrap_angle(yaw - heading)
        slide = (
            self.axles.rear_m - self.axles.rear_compliance * speed_mps * speed_mps
        ) * yaw_rate_radps
        rate = speed_mps * math.sin(heading_error) + slide * math.cos(heading_error)
        return self.feedback(
            cross_track,
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
        """The law itself: front wheel angle in radians, positive to the left, from the errors of the centre (positive to the left) and
        the path's curvature in 1/m."""
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
    """The same with the wheel angle of the road's bend fed forward, which leaves no error of position on a circle."""

    feeds_forward = True
