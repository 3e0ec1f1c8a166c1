"""All of the world together: what stands where, and what a tick, a push or a click does to it."""

from __future__ import annotations

import math

from world.car import Car, Field
from world.laps import LapCounter
from world.sensor import sense
from world.waypoints import IDX_MAX, Waypoint, check_route, ellipse, load_csv


class Simulation:
    """The field, its waypoints, the car and the laps; `settings` are those of world.settings.

    Raises world.waypoints.WaypointError for a route that cannot be driven.
    """

    def __init__(self, settings):
        self.settings = settings
        self.field = Field(settings.field_width, settings.field_height)
        if settings.waypoints_path:
            self._route = load_csv(settings.waypoints_path)
            source = settings.waypoints_path
        else:
            self._route = ellipse(
                settings.waypoint_count, settings.ellipse_width, settings.ellipse_height
            )
            source = (
                f"parameters ~ellipse_width {settings.ellipse_width:g}, "
                f"~ellipse_height {settings.ellipse_height:g}"
            )
        check_route(self._route, self.field, settings.touch_distance, source)
        self.is_paused = False
        self.reset()

    @property
    def laps(self):
        """How many laps were completed."""
        return self._lap_counter.laps

    def reset(self):
        """All as at the start: the car in its place, no laps, no added waypoints. A pause stays a pause."""
        self.car = Car(self.settings.start_x, self.settings.start_y, 0.0).turned(
            self.settings.start_direction
        )
        self.waypoints = list(self._route)
        self._lap_counter = LapCounter(self.waypoints, self.settings.touch_distance)

    def tick(self, time_step):
        """Moves the car on by `time_step` seconds unless paused; returns whether that completed a lap."""
        if self.is_paused:
            return False
        self.car = self.field.advance(
            self.car, self.settings.speed * time_step, self.settings.car_size
        )
        return self._lap_counter.update(self.car.x, self.car.y)

    def sensed(self):
        """The waypoints that the car's sensor reports now."""
        return sense(
            self.car, self.waypoints, self.settings.sensor_range, self.settings.sensor_front_only
        )

    def steer(self, delta_direction):
        """Turns the car, unless paused. Raises ValueError for what is no angle."""
        if not math.isfinite(delta_direction):
            raise ValueError(
                f"delta_direction {delta_direction} is not a finite angle; send radians"
            )
        if not self.is_paused:
            self.car = self.car.turned(delta_direction)

    def place_car(self, x, y, direction):
        """Puts the car down, at the nearest place inside the walls; the lap in progress begins anew."""
        if not all(math.isfinite(value) for value in (x, y, direction)):
            raise ValueError(f"position ({x}, {y}, {direction}) is not finite; send numbers")
        self.car = self.field.clamp(Car(x, y, direction), self.settings.car_size)
        self._lap_counter.restart_lap()

    def add_waypoint(self, x, y):
        """Adds a waypoint behind the last one; the lap in progress begins anew."""
        if not (math.isfinite(x) and math.isfinite(y)):
            raise ValueError(f"waypoint ({x}, {y}) is not finite; send numbers")
        if not self.field.contains(x, y):
            raise ValueError(
                f"waypoint ({x:g}, {y:g}) lies outside the walls; choose a place inside"
            )
        idx = max(waypoint.idx for waypoint in self.waypoints) + 1
        if idx > IDX_MAX:
            raise ValueError(f"waypoint {idx} would be one too many; reset the world")
        self.waypoints = self.waypoints + [Waypoint(idx, x, y)]
        self._lap_counter.set_waypoints(self.waypoints)
