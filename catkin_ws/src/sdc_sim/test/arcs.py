"""Roads of straights and arcs."""

import numpy as np


def route(*elements, step_m=1.0):
    """Return waypoints (N, 2) from the origin along x.

    An element is the length of a straight, or a radius and an angle, positive for a left turn.
    """
    points, yaw = [np.zeros(2)], 0.0
    for element in elements:
        radius, angle = element if isinstance(element, tuple) else (np.inf, 0.0)
        length = radius * abs(angle) if angle else element
        count = max(1, int(np.ceil(length / step_m)))
        turn = angle / count
        chord = np.sinc(0.5 * turn / np.pi) * length / count
        for _ in range(count):
            direction = yaw + 0.5 * turn
            points.append(points[-1] + chord * np.array([np.cos(direction), np.sin(direction)]))
            yaw += turn
    return np.array(points)
