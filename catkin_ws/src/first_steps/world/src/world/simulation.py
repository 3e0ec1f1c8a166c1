"""The complete world: field, waypoints, car, sensor and laps, with the actions that change them."""

from __future__ import annotations

import math
from types import SimpleNamespace

from world.car import Car, Field
from world.laps import LapCounter
from world.waypoints import IDX_MAX, Waypoint, check_route, ellipse, load_csv


class Simulation:
    """The field with its waypoints, the car and the lap counter; its methods take finite numbers.

    Raises:
        ValueError: the route is invalid
    """

    def __init__(self, settings: SimpleNamespace):
        """Create the world; `settings` are those of `world.rules.read_settings`."""
        self.settings = settings
        self.field = Field(settings.field_width, settings.field_height, settings.car_size)
        width, height = settings.ellipse_width, settings.ellipse_height
        if settings.waypoints_path:
            source = settings.waypoints_path
            self._route = load_csv(source)
        else:
            source = f"parameters ~ellipse_width {width:g}, ~ellipse_height {height:g}"
            self._route = ellipse(settings.waypoint_count, width, height)
        check_route(self._route, self.field, settings.touch_distance, source)
        self.is_paused = False
        self.reset()

    def reset(self) -> None:
        """Move the car to its start, remove added waypoints and laps; a pause continues."""
        self.car = Car(self.settings.start_x, self.settings.start_y, 0.0).turned(
            self.settings.start_direction
        )
        self.waypoints = list(self._route)
        self.lap_counter = LapCounter(self.waypoints, self.settings.touch_distance)

    def tick(self, time_step: float) -> bool:
        """Move the car for `time_step` [s] unless paused; return True if that completes a lap."""
        if self.is_paused:
            return False
        self.car = self.field.advance(self.car, self.settings.speed * time_step)
        return self.lap_counter.update(self.car.x, self.car.y)

    def sensed(self) -> list[Waypoint]:
        """Return the waypoints that the car's sensor detects now: those in its range.

        A sensor with `sensor_front_only` does not detect the points behind the car.
        """
        ahead_x, ahead_y = math.cos(self.car.direction), math.sin(self.car.direction)
        sensed = []
        for waypoint in self.waypoints:
            dx, dy = waypoint.x - self.car.x, waypoint.y - self.car.y
            is_near = dx * dx + dy * dy <= self.settings.sensor_range**2
            is_behind = dx * ahead_x + dy * ahead_y < 0.0
            if is_near and not (self.settings.sensor_front_only and is_behind):
                sensed.append(waypoint)
        return sensed

    def steer(self, delta_direction: float) -> None:
        """Turn the car by `delta_direction` [rad] unless paused."""
        if not self.is_paused:
            self.car = self.car.turned(delta_direction)

    def place_car(self, x: float, y: float, direction: float) -> None:
        """Move the car to the nearest position inside the walls and restart the current lap.

        Args:
            x: requested position [u]
            y: requested position [u]
            direction: new direction [rad]
        """
        self.car = self.field.clamp(Car(x, y, 0.0).turned(direction))
        self.lap_counter.restart_lap(self.waypoints)

    def add_waypoint(self, x: float, y: float) -> None:
        """Append a waypoint at (x, y) [u] to the route and restart the current lap.

        Raises:
            ValueError: the point is outside the walls, or the last idx is used
        """
        if not self.field.contains(x, y):
            raise ValueError(f"waypoint ({x:g}, {y:g}) is outside the walls; choose a point inside")
        idx = max(waypoint.idx for waypoint in self.waypoints) + 1
        if idx > IDX_MAX:
            raise ValueError(f"idx {idx} is above the maximum {IDX_MAX}; reset the world")
        self.waypoints = [*self.waypoints, Waypoint(idx, x, y)]
        self.lap_counter.restart_lap(self.waypoints)
