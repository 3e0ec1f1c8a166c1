"""Find traffic lights in a picture: which lamp is lit, and where the light is on the road."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import cv2
import numpy as np

from sdc_common.validation import check_between, check_positive
from sdc_perception.ground_plane import GroundPlane, MountingPose
from sdc_perception.ground_tracks import TrackSettings

# As CarlaTrafficLightStatus numbers them, from the top of the housing to the bottom.
RED, YELLOW, GREEN = 0, 1, 2
NAMES = ("red", "yellow", "green")
# Area of a regular octagon, which a round lamp is in the picture, by the square of its radius.
_OCTAGON = 2.0 * math.sqrt(2.0)
# Smooth edges make a body larger in the picture, by this much at each edge.
_LAMP_PX = 0.7
_HOUSING_PX = 1.0
_POLE_PX = 1.0
# Sizes that are tried, as a share of the size that the lamp gives.
_SIZES = np.geomspace(0.5, 1.8, 65)
_LAMP_EDGE_PX, _FOOT_DEVIATION = 0.4, 0.04
# Least brightness of a lit lamp as a share of that of the bright parts of the picture.
_LIT = 0.65
# Columns left and right of a lamp that are still housing, as a share of its width.
_ASIDE = 0.35
# Standard deviation of a distance that nothing confirms, as a share of it.
_ALONE = 0.1
# Standard deviation of an edge [px].
_EDGE_PX = 0.5


def check_pairs(**pairs: Sequence[float]) -> None:
    """Raise ValueError for the first value that is not two numbers from 0 to 180."""
    for name, pair in pairs.items():
        if len(pair) != 2 or not all(0 <= number <= 180 for number in pair):
            raise ValueError(f"{name}: write two numbers, each 0..180, got {pair}")


def colour_mask(hsv: np.ndarray, hues: tuple[int, int], least: tuple[float, float]) -> np.ndarray:
    """Return the mask (H, W) of some hues.

    Args:
        hsv: picture (H, W, 3) of hue, saturation and brightness
        hues: from and to, 0..180; the range may pass 180
        least: least saturation and brightness, 0..255
    """
    low, high = hues
    ranges = [(low, high)] if low <= high else [(low, 180), (0, high)]
    masks = [cv2.inRange(hsv, (a, *least), (b, 255, 255)) for a, b in ranges]
    return masks[0] if len(masks) == 1 else cv2.bitwise_or(*masks)


@dataclass(frozen=True)
class LampSettings:
    """What counts as a lit lamp."""

    red: tuple[int, int]  # hues, from and to, in OpenCV's range 0..180; the range may pass 180
    yellow: tuple[int, int]  # the same
    green: tuple[int, int]  # the same
    saturation: int  # least saturation, 0..255
    # Least excess of the lamp's colour over the others, as a share of the brightness of the bright
    # parts of the picture, 0..1
    excess: float
    dark: float  # greatest brightness of an unlit lamp as a share of that of the lit one, 0..1

    def __post_init__(self):
        check_pairs(**{f"lamps/{name}": getattr(self, name) for name in NAMES})
        check_between(0, 255, saturation=self.saturation)
        check_between(0.0, 1.0, excess=self.excess, dark=self.dark)


@dataclass(frozen=True)
class HousingSettings:
    """Dimensions of a traffic light."""

    height_m: float  # height of the housing [m]
    width_m: float  # width of the housing [m]
    lamp_radius_m: float  # radius of a lamp [m]
    spacing_m: float  # distance between the centres of two lamps [m]
    first_m: float  # distance of the centre of the red lamp from the top [m]
    farthest_m: float  # greatest distance at which a light counts [m]

    def __post_init__(self):
        check_positive(**vars(self))


@dataclass(frozen=True)
class LightSettings:
    """Parameters of the traffic light detector."""

    camera: MountingPose  # pose of the camera
    lamps: LampSettings  # what counts as a lit lamp
    housing: HousingSettings  # dimensions of a traffic light
    tracks: TrackSettings  # how tracks begin, move and end

    @classmethod
    def read(cls, parameter: Callable[[str], Any]) -> LightSettings:
        """Return the settings of config/traffic_light_detector.yaml, see DetectorSettings.read."""
        return cls(
            MountingPose(**parameter("camera")),
            LampSettings(**parameter("lamps")),
            HousingSettings(**parameter("housing")),
            TrackSettings(**parameter("tracks")),
        )


class SeenLight(NamedTuple):
    """A traffic light in one picture."""

    state: int  # RED, YELLOW or GREEN
    x_m: float  # position of the pole ahead of the car's centre [m]
    y_m: float  # position to the left of it [m]
    distance_deviation_m: float  # standard deviation along the line of sight [m]
    box: tuple[float, float, float, float]  # left, top, right, bottom of the housing [px]
    # Pixel where the pole meets the ground, None if it is not seen
    foot: tuple[float, float] | None


class LightFinder:
    """Finds lit lamps in housings, and measures their distance.

    A housing has a known size, and a pole meets the ground: both give the distance.
    """

    def __init__(self, settings: LightSettings, intrinsic: np.ndarray):
        """Prepare for pictures with the camera matrix K `intrinsic` (3, 3) of camera_info [px]."""
        self._focal_px = float(intrinsic[0][0])
        self._centre = float(intrinsic[0][2]), float(intrinsic[1][2])
        self._mount, self._lamps, self._housing = settings.camera, settings.lamps, settings.housing
        self._ground = GroundPlane(intrinsic, self._mount)
        # A lamp is higher than the camera.
        self._horizon = int(self._centre[1] - self._focal_px * math.tan(self._mount.pitch_rad))

    def find(self, image: np.ndarray) -> list[SeenLight]:
        """Return the lights of a picture (H, W, 3 or 4), BGR first, uint8, that face the car."""
        upper = image[: max(self._horizon, 1)]
        if upper.shape[2] == 4:
            upper = cv2.cvtColor(upper, cv2.COLOR_BGRA2BGR)
        hsv = cv2.cvtColor(upper, cv2.COLOR_BGR2HSV)
        bright = float(np.percentile(hsv[::8, ::8, 2], 95.0))
        lights = []
        for state in (RED, YELLOW, GREEN):
            hues = getattr(self._lamps, NAMES[state])
            mask = colour_mask(hsv, hues, (self._lamps.saturation, max(1.0, _LIT * bright)))
            if not cv2.countNonZero(mask):
                continue
            count, _, stats, _ = cv2.connectedComponentsWithStats(mask)
            for box in stats[1:count].tolist():
                lamp = _LampDisc.measure(upper, state, box)
                if lamp is not None and lamp.peak > self._lamps.excess * bright:
                    light = self._light(image, hsv[..., 2], state, lamp)
                    if light is not None:
                        lights.append(light)
        return lights

    def _light(
        self, image: np.ndarray, value: np.ndarray, state: int, lamp: _LampDisc
    ) -> SeenLight | None:
        """Return the light that a lit lamp belongs to, None if it is no light."""
        housing = self._housing
        radius = max(math.sqrt(lamp.area_px / _OCTAGON) - _LAMP_PX, 0.3)
        lamp_scale = radius / housing.lamp_radius_m
        if not self._others_are_dark(value, state, lamp, lamp_scale):
            return None
        foot = self._foot(image, lamp, state, lamp_scale)
        scale = self._scale_of_housing(value, state, lamp, lamp_scale, foot)
        depth, deviation = self._depth(lamp_scale, scale, foot)
        if depth > housing.farthest_m:
            return None
        return SeenLight(
            state,
            self._mount.x_m + depth,
            -(lamp.u - self._centre[0]) / self._focal_px * depth,
            deviation,
            self._box(state, lamp, self._focal_px / depth),
            foot,
        )

    def _depth(
        self, lamp_scale: float, scale: float, foot: tuple[float, float] | None
    ) -> tuple[float, float]:
        """Return the distance ahead of the camera and its standard deviation [m].

        Housing and foot of the pole give it. Where they disagree, the size of the lamp decides.
        """
        depth = self._focal_px / scale
        deviation = depth * _EDGE_PX / (scale * self._housing.height_m)
        if foot is None:
            return depth, math.hypot(deviation, _ALONE * depth)
        foot_depth = float(self._ground.points(np.array(foot))[0]) - self._mount.x_m
        foot_deviation = foot_depth * _EDGE_PX / (foot[1] - self._horizon)
        if abs(foot_depth - depth) < 3.0 * math.hypot(deviation, foot_deviation):
            weight = deviation**2 / (deviation**2 + foot_deviation**2)
            return depth + weight * (foot_depth - depth), deviation * math.sqrt(1.0 - weight)
        lamp_depth = self._focal_px / lamp_scale
        depth = min(depth, foot_depth, key=lambda estimate: abs(math.log(estimate / lamp_depth)))
        return depth, _ALONE * depth

    def _others_are_dark(
        self, value: np.ndarray, state: int, lamp: _LampDisc, scale: float
    ) -> bool:
        """Return whether the two other lamps are where they must be, and not lit.

        Next to them the housing is as dark; next to the pole below it there is the background.
        """
        most = self._lamps.dark * lamp.brightness
        aside = round(_ASIDE * self._housing.width_m * scale)
        columns = [round(lamp.u) + shift for shift in (-aside, 0, aside)]
        for other in (RED, YELLOW, GREEN):
            row = round(lamp.v + (other - state) * self._housing.spacing_m * scale)
            if other == state or row >= len(value):
                continue
            if row < 0 or columns[0] < 0 or columns[-1] >= value.shape[1]:
                return False
            if value[row, columns].max() > most:
                return False
        return True

    def _scale_of_housing(
        self,
        value: np.ndarray,
        state: int,
        lamp: _LampDisc,
        scale: float,
        foot: tuple[float, float] | None,
    ) -> float:
        """Return the most likely size of the housing in pixels a metre.

        Its edges are steep there; it is about that of the lamp, and often that of the foot.
        """
        housing, scales = self._housing, scale * _SIZES
        above_m = housing.first_m + state * housing.spacing_m
        column = value[:, round(lamp.u)].astype(float)
        row = value[round(lamp.v)].astype(float)
        steep = np.zeros(len(scales))
        for line, centre, size_m, way in (
            (column, lamp.v, above_m, -1),
            (column, lamp.v, housing.height_m - above_m, 1),
            (row, lamp.u, 0.5 * housing.width_m, -1),
            (row, lamp.u, 0.5 * housing.width_m, 1),
        ):
            steep += _rise(line, centre + way * (size_m * scales + _HOUSING_PX), way)
        likely = np.minimum(steep / (0.3 * lamp.brightness), 4.0)
        deviation = _LAMP_EDGE_PX / (scale * housing.lamp_radius_m)
        likely -= 0.5 * (np.log(_SIZES) / deviation) ** 2
        if foot is not None:
            foot_scale = (foot[1] - self._horizon) / self._mount.z_m
            likely += np.exp(-0.5 * (np.log(scales / foot_scale) / _FOOT_DEVIATION) ** 2)
        return float(scales[np.argmax(likely)])

    def _foot(
        self, image: np.ndarray, lamp: _LampDisc, state: int, scale: float
    ) -> tuple[float, float] | None:
        """Return the lowest pixel of the pole: its colour ends there."""
        above_m = self._housing.first_m + state * self._housing.spacing_m
        # The size of the lamp is rough: begin well below the housing.
        begin = round(lamp.v + 1.6 * (self._housing.height_m - above_m) * scale) + 3
        column = image[begin:, round(lamp.u), :3].astype(float)
        if len(column) < 8:
            return None
        pole = np.median(column[: max(4, round(0.5 * scale))], axis=0)
        away = np.abs(column - pole).max(axis=1) > 0.15 * pole.max() + 4.0
        if not away.any():
            return None
        row = begin + int(np.argmax(away)) - 0.5 - _POLE_PX
        return (lamp.u, row) if row > self._horizon + 4 else None

    def _box(self, state: int, lamp: _LampDisc, scale: float) -> tuple[float, float, float, float]:
        above_m = self._housing.first_m + state * self._housing.spacing_m
        top, half = lamp.v - above_m * scale, 0.5 * self._housing.width_m * scale
        bottom = top + self._housing.height_m * scale
        return lamp.u - half, top, lamp.u + half, bottom


class _LampDisc(NamedTuple):
    """A lit lamp in the picture."""

    u: float  # column of its centre [px]
    v: float  # row of its centre [px]
    area_px: float  # area of its light [px^2]
    peak: float  # greatest excess of its colour over the others, 0..255
    brightness: float  # its brightness, 0..255

    @classmethod
    def measure(cls, picture: np.ndarray, state: int, box: list[int]) -> _LampDisc | None:
        """Measure the pixels in and next to a box; one at an edge is part of the lamp by a share.

        Args:
            picture: (H, W, 3) BGR
            state: RED, YELLOW or GREEN
            box: left, top, width and height of the saturated pixels [px]

        Returns:
            the lamp, None if the box has not the shape of one
        """
        left, top, width, height = box[:4]
        if not 0.4 <= (height + 1.0) / (width + 1.0) <= 3.0:
            return None
        low = max(top - 1, 0), max(left - 1, 0)
        part = picture[low[0] : top + height + 1, low[1] : left + width + 1].astype(float)
        blue, green, red = part[..., 0], part[..., 1], part[..., 2]
        excess = (
            red - np.maximum(green, blue),
            np.minimum(red, green) - blue,
            green - np.maximum(red, blue),
        )[state]
        peak = float(excess.max())
        if peak <= 0.0:
            return None
        share = np.clip(excess / peak, 0.0, 1.0)
        share[share < 0.3] = 0.0
        rows, columns = np.indices(share.shape)
        area = float(share.sum())
        u = low[1] + float((share * columns).sum()) / area
        v = low[0] + float((share * rows).sum()) / area
        return cls(u, v, area, peak, float(part.max()))


def _rise(line: np.ndarray, edge: np.ndarray, way: int) -> np.ndarray:
    """Return by how much a line of pixels gets brighter in one direction at some places."""
    index = np.arange(len(line))
    outside, inside = (
        np.interp(edge + 0.7 * way, index, line),
        np.interp(edge - 0.7 * way, index, line),
    )
    return np.clip(outside - inside, 0.0, None)
