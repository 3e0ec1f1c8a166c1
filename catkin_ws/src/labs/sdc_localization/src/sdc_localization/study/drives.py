"""Drive on the estimate of the localizer, in lockstep; compare the estimate with the truth.

python3 -m sdc_localization.study.drives [ROUTES] prints the errors and their consistency.
"""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from typing import Any, Mapping, NamedTuple, Sequence

import numpy as np
import rosbag
from scipy.stats import chi2

from sdc_common.configuration import node_config
from sdc_common.geometry.angles import wrap_angle
from sdc_common.ros.odometry import GROUND_TRUTH, pose_and_speed
from sdc_localization.localizer import LocalizerSettings
from sdc_sim.road.random_routes import long_route
from sdc_sim.runner import isolated_drive
from sdc_sim.scenario.acceptance_limits import read_report
from sdc_sim.scenario.packaged import options_text

ROUTES = 20
OUTAGE_S = 5.0
# Of the estimate, and of the truth.
_TOPICS = ("/carla/ego_vehicle/odometry", GROUND_TRUTH)
# Probability of the band in which a consistent filter is.
_BAND = 0.95


@dataclass(frozen=True)
class LocalizedDrive:
    """The record of a drive on the estimate; a row for each tick."""

    metrics: dict[str, Any]  # the report of the referee
    times_s: np.ndarray  # (N,) simulated time [s]
    truth: np.ndarray  # (N, 3) x, y, yaw [m, m, rad]
    estimates: np.ndarray  # (N, 3) what the localizer published [m, m, rad]
    covariances: np.ndarray  # (N, 3, 3) how sure it was

    @property
    def errors(self) -> np.ndarray:
        """Errors of x, y and yaw (N, 3)."""
        rows = self.estimates - self.truth
        rows[:, 2] = [wrap_angle(yaw) for yaw in rows[:, 2]]
        return rows

    @property
    def position_errors_m(self) -> np.ndarray:
        """Distances between estimate and truth (N,)."""
        return np.hypot(*self.errors[:, :2].T)

    @property
    def nees(self) -> np.ndarray:
        """Normalized estimation errors squared of x, y and yaw (N,).

        Reference: Bar-Shalom, Li, Kirubarajan, section 5.4.2.
        """
        solved = np.linalg.solve(self.covariances, self.errors[:, :, None])[:, :, 0]
        return np.sum(self.errors * solved, axis=1)


def drive_localized(
    route_m: np.ndarray,
    seed: int = 0,
    gnss: Mapping[str, Any] | None = None,
    options: Mapping[str, Any] | None = None,
    landmarks: bool = False,
) -> LocalizedDrive:
    """Drive along a route on the estimate, with changed parameters of GNSS and localizer.

    The car starts off the middle of its lane, and turned, by as much as the localizer assumes; the
    seed draws this and the errors of the sensors.
    """
    settings = LocalizerSettings.read(node_config("sdc_localization", "localizer").__getitem__)
    deviations = settings.initial_across_m, settings.initial_yaw_rad
    left_m, turned_rad = np.random.default_rng(seed).normal(0.0, deviations).tolist()
    start = {"left_m": left_m, "turned_rad": turned_rad}
    sim_options = {"seed": seed, "start": start, "gnss": dict(gnss or {})}
    arguments = {
        "localization": "true",
        "landmarks": str(landmarks).lower(),
        "camera": "false",
        "record": "true",
        "sim_options": options_text(sim_options),
    }
    parameters = {"record": {"topics": list(_TOPICS)}, "localizer": dict(options or {})}
    received: dict[str, dict[int, Any]] = {topic: {} for topic in _TOPICS}
    with isolated_drive("", arguments, parameters, route_m) as (drive, _):
        with rosbag.Bag(os.path.splitext(drive.report_path)[0] + ".bag") as bag:
            for topic, message, _ in bag.read_messages():
                received[topic][message.header.stamp.to_nsec()] = message
        metrics = read_report(drive.report_path)[0]
    rows = []
    for stamp_ns, truth in sorted(received[GROUND_TRUTH].items()):
        estimate = received[_TOPICS[0]].get(stamp_ns)
        if estimate is not None:
            covariance = np.reshape(estimate.pose.covariance, (6, 6))
            poses = pose_and_speed(truth)[:3], pose_and_speed(estimate)[:3]
            rows.append((1e-9 * stamp_ns, *poses, covariance[np.ix_((0, 1, 5), (0, 1, 5))]))
    return LocalizedDrive(metrics, *map(np.array, zip(*rows)))


def random_drive(
    seed: int, length_m: float = 1000.0, outage_s: float | None = None
) -> LocalizedDrive:
    """Drive a random route with a GNSS outage of 5 s.

    Args:
        seed: of the route, the errors of the sensors and the start
        length_m: length of the route [m]
        outage_s: when the outage begins; None for a random time [s]
    """
    random_s = float(np.random.default_rng([seed, 1]).uniform(20.0, 90.0))
    begin_s = random_s if outage_s is None else outage_s
    outage = {"from_s": begin_s, "to_s": begin_s + OUTAGE_S}
    return drive_localized(long_route(seed, length_m), seed, {"outages": [outage]})


class Consistency(NamedTuple):
    """Whether the errors of some drives are as large as their covariances say."""

    mean: float  # mean of the normalized errors squared over all drives and ticks; 3 is ideal
    low: float  # lower end of the 95 % band of the mean over the drives at one time
    high: float  # upper end of this band
    inside: float  # share of the ticks whose mean over the drives is in the band


def consistency(drives: Sequence[LocalizedDrive]) -> Consistency:
    """Return the consistency of some drives, over the duration of the shortest one."""
    count = min(len(drive.truth) for drive in drives)
    means = np.mean([drive.nees[:count] for drive in drives], axis=0)
    low, high = chi2.ppf([0.5 - 0.5 * _BAND, 0.5 + 0.5 * _BAND], 3 * len(drives)) / len(drives)
    inside = float(np.mean((means > low) & (means < high)))
    return Consistency(float(means.mean()), float(low), float(high), inside)


def rms(values: np.ndarray) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def main() -> None:
    """Print a table of the drives, and their consistency."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else ROUTES
    drives = []
    print("| route | position error RMS | at worst | cross-track error RMS | |")
    print("|---|---|---|---|---|")
    for seed in range(count):
        drives.append(random_drive(seed))
        errors, metrics = drives[-1].position_errors_m, drives[-1].metrics
        print(
            f"| {seed} | {rms(errors):.3f} m | {errors.max():.2f} m "
            f"| {metrics['cross_track_rms_m']:.3f} m | {metrics['status']} |",
            flush=True,
        )
    everything = np.concatenate([drive.position_errors_m for drive in drives])
    found = consistency(drives)
    print(f"\nPosition error of all drives: {rms(everything):.3f} m RMS.")
    print(
        f"Normalized estimation error squared: mean {found.mean:.2f} (ideal: 3); the mean over the "
        f"drives is in its 95 % band, {found.low:.2f} to {found.high:.2f}, for {found.inside:.0%} "
        "of the time."
    )


if __name__ == "__main__":
    main()
