"""Satellite navigation: positions with errors, zones without a fix, and multipath."""

from __future__ import annotations

import math
from typing import Sequence

from sdc_common.geometry.polyline import Polyline
from sdc_common.geometry.route import Route
from sdc_sim.sensors.errors import ErrorSizes
from sdc_sim.sensors.model import Moment, SensorContext, SensorModel
from sdc_sim.sensors.readings import GNSS_MOUNT_M, GnssReading
from sdc_sim.sensors.settings import GnssSettings, Zone

# A tunnel is this wide on each side of the route: the whole road.
_ZONE_HALF_WIDTH_M = 10.0
# Reflections change while the vehicle moves past buildings.
_MULTIPATH_TIME_S = 5.0
# Added to the number of the sensor for random numbers of their own.
_SECOND_STREAM = 128


class _ZoneOnRoute:
    """Decides whether the vehicle is in a zone.

    Raises:
        ValueError: the zone is not on the route
    """

    def __init__(self, zone: Zone, route: Route | None):
        self.zone = zone
        self._line: Polyline | None = None
        if zone.from_m is None or zone.to_m is None:
            return
        if route is None:
            raise ValueError("a zone in metres needs a route; give from_s and to_s")
        if zone.to_m > route.length_m:
            raise ValueError(
                f"a zone ends {zone.to_m:g} m along a route of {route.length_m:.1f} m; "
                f"give a distance up to {route.length_m:.1f}"
            )
        inside = route.points[(route.s > zone.from_m) & (route.s < zone.to_m)].tolist()
        ends = route.line.point_at(zone.from_m), route.line.point_at(zone.to_m)
        self._line = Polyline([ends[0], *inside, ends[1]])

    def contains(self, moment: Moment) -> bool:
        """Return whether the vehicle is in the zone."""
        if self._line is None:
            return self.zone.from_s <= moment.elapsed_s < self.zone.to_s  # type: ignore[operator]
        place = self._line.nearest(moment.state.x_m, moment.state.y_m)
        return place.distance_m < _ZONE_HALF_WIDTH_M and 0.0 <= place.s_m < self._line.s[-1]


class Gnss(SensorModel):
    """A receiver above the centre of the vehicle.

    Raises:
        ValueError: a zone is not on the route
    """

    def __init__(self, settings: GnssSettings, context: SensorContext):
        sizes = ErrorSizes(settings.noise_m, settings.bias_m, settings.walk_m)
        super().__init__(context.errors([sizes] * 3))
        reflections = context._replace(number=context.number + _SECOND_STREAM)
        self._reflections = reflections.errors([ErrorSizes(1.0)] * 2)
        self._outages = [_ZoneOnRoute(zone, context.route) for zone in settings.outages]
        self._multipath = [_ZoneOnRoute(zone, context.route) for zone in settings.multipath]
        self._keep = math.exp(-context.period_s / _MULTIPATH_TIME_S)
        self._offset_m: list[float] | None = None

    def read(self, moment: Moment, tick: int) -> GnssReading:
        """Return the position of the antenna."""
        state = moment.state
        position = self.errors.apply((state.x_m, state.y_m, GNSS_MOUNT_M[2]), tick)
        offset = self._multipath_offset(moment, tick)
        if any(zone.contains(moment) for zone in self._outages):
            return GnssReading(0.0, 0.0, 0.0, False)
        return GnssReading(position[0] + offset[0], position[1] + offset[1], position[2], True)

    def _multipath_offset(self, moment: Moment, tick: int) -> Sequence[float]:
        """Return the offset of the position by reflections, a first-order Gauss-Markov process."""
        sizes = [one.zone.offset_m for one in self._multipath if one.contains(moment)]
        size = max(sizes, default=0.0)
        if size == 0.0:
            self._offset_m = None
            return (0.0, 0.0)
        draws = self._reflections.apply((0.0, 0.0), tick)
        if self._offset_m is None:
            self._offset_m = [size * draw for draw in draws]
        else:
            grow = size * math.sqrt(1.0 - self._keep**2)
            self._offset_m = [
                self._keep * offset + grow * draw for offset, draw in zip(self._offset_m, draws)
            ]
        return self._offset_m

    def reset(self) -> None:
        """Return to the start of the drive."""
        super().reset()
        self._offset_m = None
