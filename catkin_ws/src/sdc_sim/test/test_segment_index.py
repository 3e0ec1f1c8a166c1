import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_common.geometry.polyline import Polyline
from sdc_sim.road.spatial_index import SegmentIndex

COORDINATES = st.floats(-20.0, 20.0).map(lambda value: round(value, 2))
POINT = st.tuples(COORDINATES, COORDINATES)


def index_of(points, reach_m):
    points = np.array(points)
    return SegmentIndex(points[:-1], points[1:], reach_m)


@pytest.mark.slow(3)
@given(st.lists(POINT, min_size=2, max_size=12, unique=True), st.lists(POINT, min_size=1))
def test_nearest_distance_is_that_of_the_polyline(line, points):
    offsets = index_of(line, 100.0).nearest_offsets(np.array(points))
    polyline = Polyline(line, extend=False)
    expected = [polyline.nearest(x, y).distance_m for x, y in points]
    np.testing.assert_allclose(np.abs(offsets), expected, atol=1e-9)


def test_offset_is_positive_to_the_left_and_infinite_out_of_reach():
    index = index_of([(0.0, 0.0), (10.0, 0.0), (30.0, 0.0)], 5.0)
    offsets = index.nearest_offsets(np.array([(4.0, 1.0), (25.0, -2.0), (5.0, 40.0)]))
    assert offsets.tolist() == [1.0, -2.0, np.inf]
