"""Map and earth: the projection of CARLA, in both directions."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_common.geometry.geodesy import geodetic_from_map, map_from_geodetic

METRES = st.floats(-20_000.0, 20_000.0)


def test_points_are_those_of_the_equations_of_carla():
    # Mercator with the logarithm of the tangent, as in CARLA's GeoLocation.
    radius, scale = 6378137.0, math.cos(math.radians(49.0))
    x, y = 600.0, -250.0
    north = scale * radius * math.log(math.tan((90.0 + 49.0) * math.pi / 360.0)) + y
    latitude = 360.0 * math.atan(math.exp(north / (radius * scale))) / math.pi - 90.0
    longitude = 8.0 + math.degrees(x / (scale * radius))
    assert geodetic_from_map(x, y) == pytest.approx((latitude, longitude), abs=1e-11)


@given(METRES, METRES)
def test_conversion_and_back_is_within_a_micrometre(x_m, y_m):
    assert map_from_geodetic(*geodetic_from_map(x_m, y_m)) == pytest.approx((x_m, y_m), abs=1e-6)
