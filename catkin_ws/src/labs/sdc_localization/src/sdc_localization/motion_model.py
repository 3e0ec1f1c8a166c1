"""The motion model: how the state of the car changes in one step, and how uncertain it becomes."""

from __future__ import annotations

import math

import numpy as np

from sdc_common.geometry.angles import wrap_angle

# The state: position [m], heading [rad], bias of the gyroscope [rad/s], scale error of the wheels.
X, Y, YAW, BIAS, SCALE = range(5)
SIZE = 5


def moved(
    state: np.ndarray, wheel_mps: float, sideways_mps: float, gyro_radps: float, step_s: float
) -> np.ndarray:
    """Return the state after one step.

    Args:
        state: (5,) x, y, yaw, gyroscope bias, wheel scale error
        wheel_mps: speed that the wheels measure
        sideways_mps: speed of the car's centre to its left
        gyro_radps: yaw rate that the gyroscope measures
        step_s: duration of the step

    Reference: Thrun, Burgard, Fox, Probabilistic Robotics, section 5.3.3. The mean heading of the
    step replaces the circular arc, which is not defined on a straight.
    """
    x, y, yaw, bias, scale = state.tolist()
    speed = (1.0 + scale) * wheel_mps
    turn = (gyro_radps - bias) * step_s
    cos, sin = math.cos(yaw + 0.5 * turn), math.sin(yaw + 0.5 * turn)
    # TODO 1: the position and the heading after the step (until then: return state)
    x += (speed * cos - sideways_mps * sin) * step_s
    y += (speed * sin + sideways_mps * cos) * step_s
    return np.array([x, y, wrap_angle(yaw + turn), bias, scale])
    # ----------------------------------------------------------------------------


def motion_jacobian(
    state: np.ndarray, wheel_mps: float, sideways_mps: float, gyro_radps: float, step_s: float
) -> np.ndarray:
    """Return the derivatives of `moved` by the state: row = result, column = state.

    The arguments are those of `moved`; the result is (5, 5).

    Reference: Probabilistic Robotics, section 7.4, extended by bias and scale error.
    """
    turn = (gyro_radps - state[BIAS]) * step_s
    cos, sin = math.cos(state[YAW] + 0.5 * turn), math.sin(state[YAW] + 0.5 * turn)
    dx = ((1.0 + state[SCALE]) * wheel_mps * cos - sideways_mps * sin) * step_s
    dy = ((1.0 + state[SCALE]) * wheel_mps * sin + sideways_mps * cos) * step_s
    jacobian = np.eye(SIZE)
    # TODO 2: the derivatives by heading, bias and scale error (until then: pass)
    jacobian[X, YAW], jacobian[Y, YAW] = -dy, dx
    jacobian[X, BIAS], jacobian[Y, BIAS] = 0.5 * step_s * dy, -0.5 * step_s * dx
    jacobian[X, SCALE], jacobian[Y, SCALE] = wheel_mps * cos * step_s, wheel_mps * sin * step_s
    jacobian[YAW, BIAS] = -step_s
    # ----------------------------------------------------------------------------
    return jacobian


def sideways_speed(
    speed_mps: float, yaw_rate_radps: float, rear_axle_m: float, slip_s2pm: float
) -> float:
    """Return the speed of the car's centre to its left [m/s].

    The rear wheels roll where they point, and the centre is in front of them: in a bend it moves
    sideways. The rear tyres slip in proportion to the lateral acceleration, which moves it back.

    Args:
        speed_mps: speed along the car
        yaw_rate_radps: yaw rate
        rear_axle_m: distance from the rear axle to the centre
        slip_s2pm: slip angle of the rear tyres per lateral acceleration [rad/(m/s^2)]

    Reference: Rajamani, Vehicle Dynamics and Control, section 2.3 (bicycle model).
    """
    return yaw_rate_radps * (rear_axle_m - slip_s2pm * speed_mps * speed_mps)
