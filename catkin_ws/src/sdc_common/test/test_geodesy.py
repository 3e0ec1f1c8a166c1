"""Map and earth: the projection of CARLA, in both directions."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_common.geometry.geodesy import geodetic_from_map, map_from_geodetic

METRES = st.floats(-20_000.0, 20_000.0)


def test_origin_of_the_map_is_that_of_the_towns_of_carla():
    assert geodetic_from_map(0.0, 0.0) == pytest.approx((49.0, 8.0), abs=1e-12)


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


def test_metres_of_the_map_are_metres_on_the_earth():
    (south, west), (north, east) = geodetic_from_map(-50.0, -50.0), geodetic_from_map(50.0, 50.0)
    assert math.radians(north - south) * 6378137.0 == pytest.approx(100.0, abs=0.01)
    parallel = 6378137.0 * math.cos(math.radians(49.0))
    assert math.radians(east - west) * parallel == pytest.approx(100.0, abs=0.01)
