import math

import pytest

from sdc_package.local_path import ReferencePath


def straight(start=0, count=25, speed=5.0):
    return [(float(start + i), 0.0, speed) for i in range(count)]


def test_nearest_point_interpolates_place_heading_and_speed():
    path = ReferencePath()
    path.update([(0.0, 0.0, 2.0), (2.0, 0.0, 4.0), (4.0, 2.0, 4.0)])
    point = path.nearest(0.7, 0.5)
    assert (point.s_m, point.cross_track_m) == (0.7, 0.5)
    assert point.heading_rad == pytest.approx(0.35 * math.pi / 8)
    assert point.speed_mps == pytest.approx(math.sqrt((4.0 + 16.0) / 2.0)), "the speed 0.3 m ahead"
    assert point.acceleration_mps2 == pytest.approx((16.0 - 4.0) / 4.0)


def test_planned_acceleration_is_averaged_over_the_preview():
    path = ReferencePath()
    path.update([(0.0, 0.0, 4.0), (2.0, 0.0, 4.0), (4.0, 0.0, 2.0)])
    assert path.nearest(0.7, 0.0, 0.5).acceleration_mps2 == 0.0
    assert path.nearest(0.7, 0.0, 2.0).acceleration_mps2 == pytest.approx((10.0 - 16.0) / 4.0)


def test_first_and_last_segment_continue_beyond_the_ends():
    path = ReferencePath()
    path.update(straight(speed=3.0))
    assert path.nearest(-2.0, -0.5).cross_track_m == -0.5
    assert path.nearest(30.0, 1.0).cross_track_m == 1.0
    assert path.nearest(-2.0, 0.0).speed_mps == 3.0


def test_passed_points_are_kept_for_some_metres():
    path = ReferencePath()
    for start in range(30):
        path.update(straight(start))
    assert path.rows[0][0] == pytest.approx(21.0, abs=1.0)
    assert [row[0] for row in path.rows] == [path.rows[0][0] + i for i in range(len(path.rows))]
    path.update([(500.0, 500.0, 1.0), (501.0, 500.0, 1.0)])
    assert len(path.rows) == 2


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([], "a path needs at least 2 points of x, y and v, got 0"),
        ([(0.0, 0.0, 1.0)], "a path needs at least 2 points of x, y and v, got 1"),
        ([(0.0, 0.0, 1.0)] * 3, "all points of the path coincide"),
        ([(0.0, 0.0, 1.0), (1e-6, 0.0, 1.0)], "all points of the path coincide"),
        ([(0.0, math.nan, 1.0), (1.0, 0.0, 1.0)], "a point of the path is not finite"),
        ([(0.0, 0.0, math.inf), (1.0, 0.0, 1.0)], "a point of the path is not finite"),
        ([(0.0, 0.0, -1.0), (1.0, 0.0, 1.0)], "a target speed of the path is negative"),
    ],
)
def test_invalid_path_is_refused_and_the_last_one_is_kept(rows, message):
    path = ReferencePath()
    with pytest.raises(ValueError, match=f"^{message}$"):
        path.update(rows)
    assert path.empty
    path.update(straight())
    before = list(path.rows)
    with pytest.raises(ValueError, match=f"^{message}$"):
        path.update(rows)
    assert path.rows == before


def test_path_more_than_a_metre_behind_the_car_plans_a_stop():
    path = ReferencePath()
    path.update([(0.0, float(y), 8.0) for y in range(10)])
    assert path.nearest(-0.1, 10.0).speed_mps == pytest.approx(8.0)
    assert path.nearest(-0.1, 10.5) == (10.5, 0.1, math.pi / 2, 0.0, 0.0)
