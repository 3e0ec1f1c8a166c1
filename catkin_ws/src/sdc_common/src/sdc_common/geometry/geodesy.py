"""Latitude and longitude of points in the map, as CARLA's GNSS sensor reports them.

CARLA projects its maps with a spherical Mercator projection whose scale is 1 at the latitude of the
origin. Within a few kilometres of the origin, metres of the map are metres on the ground.

Reference: J. P. Snyder, Map Projections: A Working Manual, USGS, 1987, equations 7-1 to 7-4.
"""

from __future__ import annotations

import math

# The origin of the map in the towns 1 to 7 of CARLA.
REFERENCE_LATITUDE_DEG = 49.0
REFERENCE_LONGITUDE_DEG = 8.0
EARTH_RADIUS_M = 6378137.0

_SCALE_M = EARTH_RADIUS_M * math.cos(math.radians(REFERENCE_LATITUDE_DEG))
# asinh(tan(latitude)) is the isometric latitude, the same as log(tan(pi / 4 + latitude / 2)).
_NORTH_AT_REFERENCE_M = _SCALE_M * math.asinh(math.tan(math.radians(REFERENCE_LATITUDE_DEG)))


def geodetic_from_map(x_m: float, y_m: float) -> tuple[float, float]:
    """Return latitude and longitude of a point of the map, x east and y north [deg]."""
    latitude = math.atan(math.sinh((y_m + _NORTH_AT_REFERENCE_M) / _SCALE_M))
    return math.degrees(latitude), REFERENCE_LONGITUDE_DEG + math.degrees(x_m / _SCALE_M)


def map_from_geodetic(latitude_deg: float, longitude_deg: float) -> tuple[float, float]:
    """Return x [m] and y [m] in the map of a point on the earth, positive north and east."""
    north_m = _SCALE_M * math.asinh(math.tan(math.radians(latitude_deg)))
    east_m = _SCALE_M * math.radians(longitude_deg - REFERENCE_LONGITUDE_DEG)
    return east_m, north_m - _NORTH_AT_REFERENCE_M
