"""Call modules of the lab on perception with known arguments, for library_probe.py."""

from __future__ import annotations

from random import Random

import numpy as np

# Where a point has no pixel: JSON has no NaN, and `same` needs numbers.
NOWHERE = -9999.0
MOUNT = (0.7, 1.7, 0.1)
HOMOGRAPHY = np.array([[320.0, -320.0, 10.0], [200.0, 0.0, 400.0], [1.0, 0.0, 0.5]])
GROUND = np.array([[10.0, 0.0], [10.0, 2.0], [5.0, -1.75], [-3.0, 1.0]])
# Width [m], brightness inside, to the left and to the right of pairs of edges.
EDGES = np.array(
    [
        (0.15, 200.0, 80.0, 90.0),
        (0.25, 200.0, 90.0, 80.0),
        (0.15, 60.0, 150.0, 160.0),
        (0.15, 200.0, 80.0, 190.0),
        (0.15, 200.0, 190.0, 80.0),
        (0.05, 200.0, 80.0, 80.0),
        (0.5, 200.0, 80.0, 80.0),
        (0.15, 100.0, 85.0, 85.0),
    ]
)
LINES_M = np.array([-1.75, 1.75, 5.25])
LANES = np.array([(0.5, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.03)])
POINT = np.array([[10.0, 0.25]])
# Points of a lane with an offset of 0.2 m, wrong ones far to the left, and few on other lanes.
MARKINGS = np.array(
    [(x, y - 0.2) for x in (4.0, 7.0, 10.0, 13.0) for y in LINES_M]
    + [(9.0, 8.8)] * 8
    + [(5.0, -0.95), (11.0, 2.55), (8.0, -2.45), (12.0, 1.05), (6.0, 4.55)]
)
CANDIDATES = np.array([(0.7, 0.0, 0.0), (-0.8, 0.0, 0.0), (0.2, 0.0, 0.0), (1.4, -0.3, 0.0)])
LEFT, CENTRE, RIGHT = np.array([[80.0, 80.0, 190.0], [200.0, 200.0, 200.0], [90.0, 190.0, 80.0]])
DARK = (150.0, 60.0, 160.0)
POSE = (2.0, 1.0, 0.5 * np.pi)
PLACES = np.array([[2.0, 5.0], [1.0, 1.0], [5.0, 4.0]])
RESIDUALS, DEVIATIONS, SCALES = np.array([[0.0, 0.1, -0.2, 1.0], [0.1] * 4, [0.2] * 4])
DEVIATIONS[2:] = 0.05
P_INVERSE = np.array([[4.0, 1.0], [1.0, 3.0]])
JACOBIAN = np.array([[1.0, 0.0], [1.0, 2.0], [1.0, 4.0]])
WEIGHTS, MEASURED, MOVED = np.array([2.0, 1.0, 0.5]), np.array([0.3, 0.4, 0.9]), (0.1, -0.05)
SIGHTS = ((20.0, 32.0), (50.0, 32.0))
CONFIDENCES = (0.0, 0.2, 0.3, 0.4, 0.6, 1.0)


def _list(value: object) -> list:
    return np.nan_to_num(np.asarray(value, float), nan=NOWHERE).tolist()


def ground_plane(random: Random) -> dict:
    """Return matrices of cameras, and projected points."""
    from sdc_perception.ground_plane import MountingPose, optical_frame, projected

    mount = MountingPose(random.uniform(0.5, 2.0), random.uniform(1.0, 2.0), random.uniform(0, 0.3))
    return {
        "other": [
            _list(optical_frame(mount)),
            _list(projected(HOMOGRAPHY, GROUND * random.uniform(0.8, 1.2))),
        ],
        "frame": _list(optical_frame(MountingPose(*MOUNT))),
        "pixels": _list(projected(HOMOGRAPHY, GROUND)),
    }


def marking_filter(random: Random) -> dict:
    """Return which edges are markings, and the differences of a ridge filter."""
    from sdc_perception.marking_filter import are_markings, ridge

    light = random.uniform(0.7, 1.2)
    boxes = np.array([LEFT, CENTRE, RIGHT])
    return {
        "other": [
            [float(one) for one in are_markings(EDGES[:, 0], *(light * EDGES[:, 1:]).T)],
            _list(ridge(*(light * boxes))),
        ],
        "markings": [bool(one) for one in are_markings(*EDGES.T)],
        "ridge": _list(ridge(*boxes)),
        "dark": _list(ridge(*np.array(DARK)[:, None])),
    }


def lane_model(random: Random) -> dict:
    """Return distances of a point to the lines of lanes, and the best of some lanes."""
    from sdc_perception.lane_model import best_lane, distances_to_lines

    first = random.randrange(3)
    shift = random.uniform(-0.5, 0.5)
    moved, shifted = CANDIDATES + [shift, 0.0, 0.0], MARKINGS - [0.0, shift]
    order = [*range(first, len(moved)), *range(first)]
    return {
        "other": [
            _list(distances_to_lines(LANES + shift, POINT, LINES_M)),
            _list(best_lane(moved[order], shifted, LINES_M)),
        ],
        "distances": _list(distances_to_lines(LANES, POINT, LINES_M)),
        "best": _list(best_lane(CANDIDATES, MARKINGS, LINES_M)),
    }


def vehicle_frame(random: Random) -> dict:
    """Return points as a car sees them."""
    from sdc_perception.vehicle_frame import in_vehicle_frame

    pose = tuple(random.uniform(-3.0, 3.0) for _ in range(3))
    return {
        "other": _list(in_vehicle_frame(PLACES, pose)),
        "points": _list(in_vehicle_frame(PLACES, POSE)),
    }


def robust_fit(random: Random) -> dict:
    """Return weights, and a correction with its covariance."""
    from sdc_perception.robust_fit import correction, robust_weights

    def corrected(factor: float) -> list:
        residuals, moved = factor * MEASURED, np.array(MOVED)
        return [*map(_list, correction(P_INVERSE, JACOBIAN, WEIGHTS, residuals, moved))]

    factor = random.uniform(0.5, 2.0)
    return {
        "other": [
            _list(robust_weights(factor * RESIDUALS, DEVIATIONS, SCALES)),
            corrected(factor),
        ],
        "weights": _list(robust_weights(RESIDUALS, DEVIATIONS, SCALES)),
        "correction": corrected(1.0),
    }


def stamp_pairing(random: Random) -> dict:
    """Return the messages of a stamp, as numbers: 10 for each topic and 1 for each tick."""
    from sdc_perception.stamp_pairing import messages_with_stamp

    def found(stamp: int, *ticks: tuple) -> list:
        waiting = [{tick: 10 * topic + tick for tick in one} for topic, one in enumerate(ticks)]
        messages = messages_with_stamp(waiting, stamp)
        return [-1] if messages is None else list(messages)

    first = random.randrange(3, 6)
    several = tuple(range(first - 2, first + 3))
    return {
        "other": [found(first, several, several[1:], several[:-1]), found(first, (first,), (1,))],
        "together": found(2, (1, 2), (1, 2, 3), (2, 3)),
        "picture missing": found(2, (1,), (1, 2), (2,)),
    }


def lane_following(random: Random) -> dict:
    """Return ends of paths, and shares of the speed."""
    from sdc_perception.lane_following import path_end, speed_share

    low, high = random.uniform(0.1, 0.3), random.uniform(0.5, 0.9)
    return {
        "other": [
            *(float(path_end(random.uniform(5.0, 40.0), 25.0)) for _ in range(4)),
            *(float(speed_share(one, low, high)) for one in CONFIDENCES),
        ],
        "ends": [float(path_end(*one)) for one in SIGHTS],
        "shares": [float(speed_share(one, 0.2, 0.6)) for one in CONFIDENCES],
    }


PERCEPTION_PROBES = {
    probe.__name__: probe
    for probe in (
        ground_plane,
        marking_filter,
        lane_model,
        vehicle_frame,
        robust_fit,
        stamp_pairing,
        lane_following,
    )
}
