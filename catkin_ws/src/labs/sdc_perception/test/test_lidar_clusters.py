import math

import pytest

from sdc_perception.lidar_clusters import CAR, PEDESTRIAN, Cluster, find_clusters
from sdc_perception.lidar_scenes import empty_road, scans, score


@pytest.mark.parametrize("pitch_rad", [0.0, 0.035, -0.035])
def test_ground_and_rain_are_no_clusters(pitch_rad):
    assert find_clusters(empty_road(pitch_rad=pitch_rad, rain=40)) == []


def test_car_and_pedestrians_are_found_where_they_are():
    bodies = ("car", 14.0, 3.0, 0.8), ("pedestrian", 9.0, -1.0, 0.0), ("pedestrian", 9.0, 0.3, 0.0)
    found = sorted(find_clusters(empty_road(*bodies)))
    assert [one.label for one in found] == [CAR, PEDESTRIAN, PEDESTRIAN]
    for one, (_, x, y, _) in zip(found, bodies):
        assert math.hypot(one.x_m - x, one.y_m - y) < 0.5
    assert found[0].yaw_rad == pytest.approx(0.8, abs=0.1)


def test_score_counts_what_is_missed_and_what_is_wrong():
    examples = scans(2)
    assert min(score(find_clusters, examples)) > 0.75
    assert score(lambda points: [], examples).recall == 0.0
    far_left = Cluster(CAR, 0.0, 9.0, 4.0, 2.0, 0.0, 1.5)
    assert score(lambda points: [far_left], examples).precision == 0.0
