import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_common.geometry.polyline import Polyline
from sdc_sim.road.road import SegmentIndex

COORDINATES = st.floats(-20.0, 20.0).map(lambda value: round(value, 2))
POINT = st.tuples(COORDINATES, COORDINATES)


def index_of(points, reach_m):
    points = np.array(points)
    return SegmentIndex(points[:-1], points[1:], reach_m)


@pytest.mark.slow(3)
@given(st.lists(POINT, min_size=2, max_size=12, unique=True), st.lists(POINT, min_size=1))
def test_nearest_distance_is_that_of_the_polyline(line, points):
    index = index_of(line, 100.0)
    polyline = Polyline(line, extend=False)
    for point in points:
        distance = polyline.nearest(*point).distance_m
        inside, outside = distance + 1e-6, distance - 1e-6
        assert index.between(np.array([point]), -inside, inside)
        assert not index.between(np.array([point]), -outside, outside)


def test_distance_is_positive_to_the_left_and_ends_at_the_reach():
    index = index_of([(0.0, 0.0), (10.0, 0.0), (30.0, 0.0)], 5.0)
    points = np.array([(4.0, 1.0), (25.0, -2.0), (5.0, 40.0)])
    assert index.between(points, 0.5, 50.0).tolist() == [True, False, False]
    assert index.between(points, -2.5, 0.5).tolist() == [False, True, False]
