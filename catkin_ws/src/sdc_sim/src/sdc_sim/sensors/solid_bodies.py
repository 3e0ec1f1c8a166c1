"""Solid bodies on the ground, and where the beams of a lidar enter and leave them."""

from __future__ import annotations

from typing import NamedTuple, Sequence, TypeVar

import numpy as np

FAR_M = 1e9
_TURN = 2.0 * np.pi


class Frusta(NamedTuple):
    """Bodies with four sides, a horizontal top and a horizontal bottom, one row each.

    Attributes:
        position_m: origin in the map (N, 2)
        yaw_rad: direction of the body's x axis in the map (N,)
        reach_m: distances from the origin to the front, rear, left and right side at the bottom
            (N, 4)
        lean: by how much these distances grow for each metre upwards (N, 4)
        bottom_m: height of the bottom (N,)
        top_m: height of the top (N,)
    """

    position_m: np.ndarray
    yaw_rad: np.ndarray
    reach_m: np.ndarray
    lean: np.ndarray
    bottom_m: np.ndarray
    top_m: np.ndarray


class Cylinders(NamedTuple):
    """Upright cylinders: position_m (N, 2), radius_m (N,), bottom_m (N,), top_m (N,)."""

    position_m: np.ndarray
    radius_m: np.ndarray
    bottom_m: np.ndarray
    top_m: np.ndarray


class Balls(NamedTuple):
    """Balls: position_m (N, 2) and height_m (N,) of the centre, radius_m (N,)."""

    position_m: np.ndarray
    height_m: np.ndarray
    radius_m: np.ndarray


_Rows = TypeVar("_Rows", Frusta, Cylinders, Balls)


def joined(parts: Sequence[_Rows]) -> _Rows:
    """Return all rows of several bodies of one kind."""
    return type(parts[0])(*(np.concatenate(columns) for columns in zip(*parts)))


def chosen(bodies: _Rows, rows: np.ndarray) -> _Rows:
    """Return these rows of bodies."""
    return type(bodies)(*(column[rows] for column in bodies))


class PlacedBodies:
    """Bodies of one kind, with what does not depend on the place of the lidar.

    Attributes:
        x_m: their origins in the map (N,)
        y_m: their origins in the map (N,)
        bottom_m: heights of the bottom (N,), None where the kind has none
        top_m: heights of the top (N,), None where the kind has none
    """

    def __init__(
        self,
        position_m: np.ndarray,
        bottom_m: np.ndarray | None = None,
        top_m: np.ndarray | None = None,
    ):
        self.x_m, self.y_m = position_m[:, 0].copy(), position_m[:, 1].copy()
        self.bottom_m, self.top_m = bottom_m, top_m

    def __len__(self) -> int:
        return len(self.x_m)

    def angles(
        self, x_m: float, y_m: float, dx: np.ndarray, dy: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the least and the largest direction in the map of each body (N,) [rad].

        Args:
            x_m: place of the lidar
            y_m: place of the lidar
            dx: from there to the origins (N,) [m]
            dy: from there to the origins (N,) [m]
        """
        raise NotImplementedError

    def inside(
        self,
        owner: np.ndarray,
        dx: np.ndarray,
        dy: np.ndarray,
        east: np.ndarray,
        north: np.ndarray,
        slopes: np.ndarray | None,
        height_m: float,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the distances on the ground at which beams enter and leave their bodies.

        Args:
            owner: number of the body of each beam (B,)
            dx: from the lidar to the origins (N,) [m]
            dy: from the lidar to the origins (N,) [m]
            east: direction of each beam (B,)
            north: direction of each beam (B,)
            slopes: slope of each ring (R, 1), None if all are level
            height_m: height of the lidar

        Returns:
            arrays (B,) or (R, B) that do not consider bottom and top
        """
        raise NotImplementedError


class PlacedFrusta(PlacedBodies):
    """Frusta; see there."""

    def __init__(self, frusta: Frusta):
        super().__init__(frusta.position_m, frusta.bottom_m, frusta.top_m)
        self._c, self._s = np.cos(frusta.yaw_rad), np.sin(frusta.yaw_rad)
        self._reach_m, self._lean = frusta.reach_m.T.copy(), frusta.lean.T.copy()
        self._leans = bool(frusta.lean.any())
        high = frusta.top_m - frusta.bottom_m
        self._widest_m = np.maximum(self._reach_m, self._reach_m + self._lean * high)
        front, rear, left, right = self._widest_m
        along, across = (
            np.stack([front, front, -rear, -rear]),
            np.stack([left, -right, left, -right]),
        )
        self._corner_x_m = self.x_m + self._c * along - self._s * across
        self._corner_y_m = self.y_m + self._s * along + self._c * across

    def angles(
        self, x_m: float, y_m: float, dx: np.ndarray, dy: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """See PlacedBodies.angles."""
        corners = np.arctan2(self._corner_y_m - y_m, self._corner_x_m - x_m)
        # Seen from outside, no corner is a half turn away from the first one.
        from_first = corners - corners[0]
        from_first -= _TURN * np.rint(from_first / _TURN)
        low, high = corners[0] + from_first.min(axis=0), corners[0] + from_first.max(axis=0)
        ahead, left = self._offset(dx, dy)
        front_m, rear_m, left_m, right_m = self._widest_m
        inside = (-ahead < front_m) & (ahead < rear_m) & (-left < left_m) & (left < right_m)
        if inside.any():
            low[inside], high[inside] = 0.0, _TURN
        return low, high

    def _offset(self, dx: np.ndarray, dy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the origins along and across their own axes, from the lidar."""
        return self._c * dx + self._s * dy, self._c * dy - self._s * dx

    def inside(
        self,
        owner: np.ndarray,
        dx: np.ndarray,
        dy: np.ndarray,
        east: np.ndarray,
        north: np.ndarray,
        slopes: np.ndarray | None,
        height_m: float,
    ) -> tuple[np.ndarray, np.ndarray]:
        """See PlacedBodies.inside."""
        c, s = self._c[owner], self._s[owner]
        ahead, aside = c * east + s * north, c * north - s * east
        along, across = self._offset(dx, dy)
        front, rear, left, right = self._reach_m
        if not self._leans:
            # A beam moves by (ahead, aside) for each metre, from (-along, -across).
            low, high = ((along - rear)[owner] / ahead, (along + front)[owner] / ahead)
            near, far = ((across - right)[owner] / aside, (across + left)[owner] / aside)
            enter = np.maximum(np.minimum(low, high), np.minimum(near, far))
            return enter, np.minimum(np.maximum(low, high), np.maximum(near, far))
        assert self.bottom_m is not None
        above_m = height_m - self.bottom_m
        enter, leave = np.full(1, -FAR_M), np.full(1, FAR_M)
        for reach, lean, origin, speed in (
            (front, self._lean[0], along, ahead),
            (rear, self._lean[1], -along, -ahead),
            (left, self._lean[2], across, aside),
            (right, self._lean[3], -across, -aside),
        ):
            gap = (reach + origin + lean * above_m)[owner]
            if slopes is not None:
                speed = speed - lean[owner] * slopes
            side = gap / speed
            enter = np.maximum(enter, np.where(speed < 0.0, side, -FAR_M))
            leave = np.minimum(leave, np.where(speed > 0.0, side, FAR_M))
            leave = np.where((speed == 0.0) & (gap < 0.0), -1.0, leave)
        return enter, leave


class _RoundBodies(PlacedBodies):
    """Bodies that are circles from above."""

    def __init__(
        self,
        position_m: np.ndarray,
        radius_m: np.ndarray,
        bottom_m: np.ndarray | None = None,
        top_m: np.ndarray | None = None,
    ):
        super().__init__(position_m, bottom_m, top_m)
        self.radius_m = radius_m

    def angles(
        self, x_m: float, y_m: float, dx: np.ndarray, dy: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """See PlacedBodies.angles."""
        share = self.radius_m / np.sqrt(dx * dx + dy * dy)
        half = np.arcsin(np.minimum(share, 1.0))
        half[share >= 1.0] = np.pi
        middle = np.arctan2(dy, dx)
        return middle - half, middle + half


class PlacedCylinders(_RoundBodies):
    """Cylinders; see there."""

    def __init__(self, cylinders: Cylinders):
        super().__init__(*cylinders)

    def inside(
        self,
        owner: np.ndarray,
        dx: np.ndarray,
        dy: np.ndarray,
        east: np.ndarray,
        north: np.ndarray,
        slopes: np.ndarray | None,
        height_m: float,
    ) -> tuple[np.ndarray, np.ndarray]:
        """See PlacedBodies.inside."""
        along = dx[owner] * east + dy[owner] * north
        half = np.sqrt(along * along + (self.radius_m**2 - dx * dx - dy * dy)[owner])
        return along - half, along + half


class PlacedBalls(_RoundBodies):
    """Balls; see there."""

    def __init__(self, balls: Balls):
        super().__init__(balls.position_m, balls.radius_m)
        self._height_m = balls.height_m

    def inside(
        self,
        owner: np.ndarray,
        dx: np.ndarray,
        dy: np.ndarray,
        east: np.ndarray,
        north: np.ndarray,
        slopes: np.ndarray | None,
        height_m: float,
    ) -> tuple[np.ndarray, np.ndarray]:
        """See PlacedBodies.inside."""
        dz = self._height_m - height_m
        along = dx[owner] * east + dy[owner] * north
        square = (dx * dx + dy * dy + dz * dz - self.radius_m**2)[owner]
        steep = np.ones(1)
        if slopes is not None:
            along = along + slopes * dz[owner]
            steep = 1.0 + slopes * slopes
        half = np.sqrt(along * along - steep * square)
        return (along - half) / steep, (along + half) / steep
