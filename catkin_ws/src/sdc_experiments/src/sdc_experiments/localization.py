"""How well the lab's localizer knows where the car is: drives on its estimate, without ROS.

python3 -m sdc_experiments.localization [ROUTES] prints the errors and their consistency.
"""

from __future__ import annotations

import dataclasses
import math
import sys
from dataclasses import dataclass, field, replace
from typing import Any, Mapping

import numpy as np
from scipy.stats import chi2

from sdc_common.driving import Command, Observation, yaw_as_sent
from sdc_common.geometry.angles import wrap_angle
from sdc_common.geometry.road_line import road_route
from sdc_experiments.closed_loop import car_with
from sdc_experiments.configuration import node_parameters, vehicle_preset
from sdc_localization.landmark_map import landmarks as scenery_landmarks
from sdc_localization.landmarks import LandmarkMap
from sdc_localization.localizer import Estimate, Localizer, LocalizerSettings
from sdc_localization.odometry_message import wheel_speed
from sdc_localization.scan_features import find_features
from sdc_package.car import EstimatingCar, MissionDriver
from sdc_package.local_planner import PlannerSettings
from sdc_sim.evaluation.ideal_drive import IdealDrive
from sdc_sim.evaluation.route_progress import RouteProgress, TerminationLimits
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.road.random_routes import long_route
from sdc_sim.road.road import Road
from sdc_sim.scenario.configuration import start_pose
from sdc_sim.scenario.packaged import node_config
from sdc_sim.sensors.readings import WHEELS, SensorReadings
from sdc_sim.sensors.settings import sensor_settings
from sdc_sim.sensors.suite import SensorSuite
from sdc_sim.simulation import loop
from sdc_sim.simulation.simulation import Simulation
from sdc_sim.simulation.snapshot import Snapshot

ROUTES = 20
OUTAGE_S = 5.0
TICK_S = 0.05
_LIMITS = TerminationLimits(
    off_route_m=15.0, off_route_s=0.5, blocked_s=30.0, finish_within_m=2.0, timeout_s=600.0
)
# Probability of the band in which a consistent filter is.
_BAND = 0.95


def localizer_configuration() -> dict:
    """Return the parameters of the node localizer."""
    return node_config("sdc_localization", "localizer")


def sensor_configuration(name: str = "localization") -> dict:
    """Return the parameters of the sensors of a file in sdc_sim/config/sensors."""
    return node_config("sdc_sim", f"sensors/{name}")


@dataclass
class LocalizedDrive:
    """The record of a drive on the estimate; a row for each tick.

    Attributes:
        progress: the drive as the referee measures it
        metrics: its metrics
        truth: x, y, yaw [m, m, rad]
        estimates: what the localizer published
        dead_reckoned: x and y by the wheels and the gyroscope alone [m]
        fixes: x and y of the GNSS, NaN without a fix [m]
    """

    progress: RouteProgress
    metrics: dict = field(default_factory=dict)
    truth: list = field(default_factory=list)
    estimates: list[Estimate] = field(default_factory=list)
    dead_reckoned: list = field(default_factory=list)
    fixes: list = field(default_factory=list)

    @property
    def errors(self) -> np.ndarray:
        """Errors of x, y and yaw (N, 3)."""
        rows = np.array([estimate[:3] for estimate in self.estimates]) - self.truth
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
        errors = self.errors
        covariances = np.array([estimate.covariance for estimate in self.estimates])
        solved = np.linalg.solve(covariances, errors[:, :, None])[:, :, 0]
        return np.sum(errors * solved, axis=1)


class _Car:
    """The localizer as its node runs it, and the same without GNSS."""

    variance_m2 = 1.0

    def __init__(self, route_m: np.ndarray, options: Mapping[str, Any], landmarks: bool):
        self._parameters = {**localizer_configuration(), **options}
        parameters = self._parameters
        settings = LocalizerSettings.read(parameters.__getitem__)
        self.localizer, self.dead_reckoning = Localizer(settings), Localizer(settings)
        self._route_m = route_m
        self._landmarks: LandmarkMap | None = None
        if landmarks:
            self._landmarks = LandmarkMap(
                scenery_landmarks(Road(route_m).scenery()),
                parameters["landmark_range_m"],
                parameters["landmark_bearing_rad"],
                parameters["gate_2"],
            )

    def locate(self, time_s: float, readings: SensorReadings) -> Estimate:
        assert readings.imu is not None
        assert readings.wheel_speeds_radps is not None
        names = [f"{wheel}_wheel" for wheel in WHEELS]
        radius_m = self._parameters["wheel_radius_m"]
        speed = wheel_speed(names, readings.wheel_speeds_radps, radius_m)
        for one in (self.localizer, self.dead_reckoning):
            one.move(time_s, speed, readings.imu.rate_radps[2])
        fix = readings.gnss
        if fix is not None and fix.has_fix:
            if self.localizer.started:
                self.localizer.add_position(fix.x_m, fix.y_m, self.variance_m2)
            else:
                self.start(fix.x_m, fix.y_m)
        if self._landmarks is not None and readings.planar_lidar is not None:
            scan = readings.planar_lidar[:, :2].astype(float)
            features = find_features(scan, self._parameters["pole_radius_m"])
            ahead_m = self._parameters["lidar_ahead_m"], 0.0
            self._landmarks.correct(self.localizer, features + ahead_m)
        return self.localizer.estimate

    def start(self, x_m: float, y_m: float) -> None:
        for one in (self.localizer, self.dead_reckoning):
            one.start(x_m, y_m, self.variance_m2, self._route_m)


def drive_localized(
    route_m: np.ndarray,
    seed: int = 0,
    outages: list | None = None,
    sensors: Mapping[str, Mapping] | None = None,
    options: Mapping[str, Any] | None = None,
    landmarks: bool = False,
) -> LocalizedDrive:
    """Drive along a route on the estimate.

    The car starts off the middle of its lane, and turned, by as much as the localizer assumes.

    Args:
        route_m: (N, 2) waypoints [m]
        seed: of the errors of the sensors and of the start
        outages: GNSS outages, as in config/sim.yaml
        sensors: changed parameters of the sensors
        options: changed parameters of the localizer
        landmarks: whether the localizer uses the planar lidar and the map
    """
    route = road_route(route_m)
    car = _Car(route_m, options or {}, landmarks)
    rows = sensor_configuration("localization_lidar" if landmarks else "localization")
    for name, changes in (*(sensors or {}).items(), ("gnss", {"outages": outages or []})):
        rows[name] = {**rows.get(name, {}), **changes}
    simulation = _simulation(route, route_m, seed, rows, car.localizer.settings)
    settings = PlannerSettings.read(node_parameters("local_planner").__getitem__)
    drive = LocalizedDrive(RouteProgress(route, _LIMITS))

    def estimate(observation: Observation) -> Observation:
        seconds, nanoseconds = divmod(observation.stamp_ns, 1_000_000_000)
        found = car.locate(seconds + 1e-9 * nanoseconds, observation.readings)
        drive.estimates.append(found)
        drive.dead_reckoned.append(car.dead_reckoning.estimate[:2])
        x_m, y_m, yaw_rad = found[:3]
        speed_mps = math.hypot(found.speed_mps, found.sideways_mps)
        yaw_rad = yaw_as_sent(yaw_rad)
        return replace(observation, x_m=x_m, y_m=y_m, yaw_rad=yaw_rad, speed_mps=speed_mps)

    driver = EstimatingCar(car_with(MissionDriver(route_m, settings)), estimate)
    loop.drive(simulation, driver, _Recorder(drive, simulation))
    drive.metrics = drive.progress.metrics(IdealDrive(route, settings.limits).duration_s)
    return drive


class _Recorder:
    """Records truth and fixes of a drive."""

    def __init__(self, drive: LocalizedDrive, simulation: Simulation):
        self._drive, self._simulation = drive, simulation

    def add(self, snapshot: Snapshot) -> bool:
        drive, state, fix = self._drive, snapshot.state, snapshot.readings.gnss
        drive.truth.append((state.x_m, state.y_m, state.yaw_rad))
        has_fix = fix is not None and fix.has_fix
        drive.fixes.append((fix.x_m, fix.y_m) if fix and has_fix else (math.nan, math.nan))
        speed = math.hypot(state.speed_mps, state.lateral_speed_mps)
        yaw = wrap_angle(state.yaw_rad)
        drive.progress.update(self._simulation.elapsed_s, state.x_m, state.y_m, yaw, speed)
        return drive.progress.status is not None

    def add_answer(self, snapshot: Snapshot, command: Command | None, car: loop.Driver) -> None:
        return


def _simulation(
    route: Any, route_m: np.ndarray, seed: int, rows: Mapping, assumed: LocalizerSettings
) -> Simulation:
    parameters = vehicle_preset("tesla_model3")
    settings = {name: sensor_settings(name, values) for name, values in rows.items()}
    random = np.random.default_rng(seed)
    left_m, turned_rad = random.normal(0.0, (assumed.initial_across_m, assumed.initial_yaw_rad))
    return Simulation(
        Vehicle(parameters),
        TICK_S,
        0.0,
        start=start_pose(route, 0.0, float(left_m), float(turned_rad)),
        sensors=SensorSuite(
            settings, parameters, TICK_S, seed, route, lambda: Road(route_m).scenery()
        ),
    )


def random_drive(seed: int, **options: Any) -> LocalizedDrive:
    """Drive a random route of 1 km with a GNSS outage of 5 s at a random time."""
    begin_s = float(np.random.default_rng([seed, 1]).uniform(20.0, 90.0))
    outage = {"from_s": begin_s, "to_s": begin_s + OUTAGE_S}
    return drive_localized(long_route(seed), seed, [outage], **options)


@dataclass(frozen=True)
class Consistency:
    """Whether the errors of some drives are as large as their covariances say.

    Attributes:
        mean: mean of the normalized errors squared over all drives and ticks; 3 is ideal
        low: lower end of the 95 % band of the mean over the drives at one time
        high: upper end of this band
        inside: share of the ticks whose mean over the drives is in the band
    """

    mean: float
    low: float
    high: float
    inside: float


def consistency(drives: list[LocalizedDrive]) -> Consistency:
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
    print(
        "| route | position error RMS | at worst | cross-track error RMS | |\n|---|---|---|---|---|"
    )
    for seed in range(count):
        drives.append(random_drive(seed))
        errors, metrics = drives[-1].position_errors_m, drives[-1].metrics
        print(
            f"| {seed} | {rms(errors):.3f} m | {errors.max():.2f} m "
            f"| {metrics['cross_track_rms_m']:.3f} m | {metrics['status']} |",
            flush=True,
        )
    everything = np.concatenate([drive.position_errors_m for drive in drives])
    found = dataclasses.asdict(consistency(drives))
    print(f"\nPosition error of all drives: {rms(everything):.3f} m RMS.")
    print(
        "Normalized estimation error squared: mean {mean:.2f} (ideal: 3); the mean over the drives "
        "is in its 95 % band, {low:.2f} to {high:.2f}, for {inside:.0%} of the time.".format(
            **found
        )
    )


if __name__ == "__main__":
    main()
