"""The complete world: field, waypoints, car and laps, with the actions that change them."""

from __future__ import annotations

import math

from world.car import Car, Field
from world.laps import LapCounter
from world.sensor import sense
from world.settings import Settings
from world.waypoints import IDX_MAX, Waypoint, check_route, ellipse, load_csv


class Simulation:
    """The field with its waypoints, the car and the lap counter.

    Raises:
        world.waypoints.WaypointError: the route is invalid
    """

    def __init__(self, settings: Settings):
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
    def laps(self) -> int:
        """Number of completed laps."""
        return self._lap_counter.laps

    def reset(self) -> None:
        """Move the car to its start, remove added waypoints and laps; a pause continues."""
        self.car = Car(self.settings.start_x, self.settings.start_y, 0.0).turned(
            self.settings.start_direction
        )
        self.waypoints = list(self._route)
        self._lap_counter = LapCounter(self.waypoints, self.settings.touch_distance)

    def tick(self, time_step: float) -> bool:
        """Move the car for `time_step` [s] unless paused; return True if that completes a lap."""
        if self.is_paused:
            return False
        self.car = self.field.advance(
            self.car, self.settings.speed * time_step, self.settings.car_size
        )
        return self._lap_counter.update(self.car.x, self.car.y)

    def sensed(self) -> list[Waypoint]:
        """Return the waypoints that the car's sensor detects now."""
        return sense(
            self.car, self.waypoints, self.settings.sensor_range, self.settings.sensor_front_only
        )

    def steer(self, delta_direction: float) -> None:
        """Turn the car by `delta_direction` [rad] unless paused.

        Raises:
            ValueError: the angle is not finite
        """
        if not math.isfinite(delta_direction):
            raise ValueError(
                f"delta_direction {delta_direction} is not a finite angle; send radians"
            )
        if not self.is_paused:
            self.car = self.car.turned(delta_direction)

    def place_car(self, x: float, y: float, direction: float) -> None:
        """Move the car to the nearest position inside the walls and restart the current lap.

        Args:
            x: requested position [u]
            y: requested position [u]
            direction: new direction [rad]

        Raises:
            ValueError: a value is not finite
        """
        if not all(math.isfinite(value) for value in (x, y, direction)):
            raise ValueError(f"position ({x}, {y}, {direction}) is not finite; send numbers")
        self.car = self.field.clamp(Car(x, y, direction), self.settings.car_size)
        self._lap_counter.restart_lap()

    def add_waypoint(self, x: float, y: float) -> None:
        """Append a waypoint at (x, y) [u] to the route and restart the current lap.

        Raises:
            ValueError: the point is not finite or outside the walls, or the last idx is used
        """
        if not (math.isfinite(x) and math.isfinite(y)):
            raise ValueError(f"waypoint ({x}, {y}) is not finite; send numbers")
        if not self.field.contains(x, y):
            raise ValueError(f"waypoint ({x:g}, {y:g}) is outside the walls; choose a point inside")
        idx = max(waypoint.idx for waypoint in self.waypoints) + 1
        if idx > IDX_MAX:
            raise ValueError(f"idx {idx} is above the maximum {IDX_MAX}; reset the world")
        self.waypoints = [*self.waypoints, Waypoint(idx, x, y)]
        self._lap_counter.set_waypoints(self.waypoints)
