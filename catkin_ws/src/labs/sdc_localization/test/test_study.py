"""The car drives on the estimate of the localizer; errors and covariances match."""

import numpy as np
import pytest

from sdc_common.configuration import node_config, package_folder
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_localization.study.drives import consistency, drive_localized, random_drive, rms
from sdc_sim.road.random_routes import long_route

pytestmark = pytest.mark.slow(15)


@pytest.mark.nightly
def test_errors_are_as_large_as_the_covariance_says():
    drives = [random_drive(seed, length_m=400.0, outage_s=15.0) for seed in range(4)]
    assert {drive.metrics["status"] for drive in drives} == {"completed"}
    found = consistency(drives)
    assert found.inside > 0.85, "of the time; with few drives the share varies"
    assert 2.0 < found.mean < 4.0
    assert rms(np.concatenate([drive.position_errors_m for drive in drives])) < 0.20


@pytest.mark.nightly
def test_gate_keeps_reflections_from_moving_the_estimate():
    gnss = {"multipath": [{"from_s": 20.0, "to_s": 30.0, "offset_m": 8.0}]}
    route = long_route(3, 300.0)
    worst_m = [
        drive_localized(route, 3, gnss, {"gate_2": gate}).position_errors_m.max()
        for gate in (node_config("sdc_localization", "localizer")["gate_2"], 1e9)
    ]
    assert worst_m[0] < 0.5 * worst_m[1]


@pytest.mark.nightly
def test_landmarks_carry_the_car_through_a_tunnel_of_20_s():
    gnss = {"outages": [{"from_s": 20.0, "to_s": 40.0}]}
    drive = drive_localized(long_route(2, 400.0), 2, gnss, landmarks=True)
    end = np.searchsorted(drive.times_s, 39.9)
    assert drive.position_errors_m[end] < 0.5
    assert drive.position_errors_m.max() < 2.0
    assert drive.metrics["status"] == "completed"


@pytest.mark.nightly
def test_town_is_driven_on_the_estimate():
    path = f"{package_folder('sdc_common')}/data/waypoints.csv"
    metrics = drive_localized(load_waypoints(path)).metrics
    assert metrics["status"] == "completed"
    assert metrics["cross_track_rms_m"] <= 0.25
    assert metrics["comfortable"]
