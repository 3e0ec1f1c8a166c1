"""Constants and pixel operations that the parts of the renderer share."""

from __future__ import annotations

from typing import Sequence

import cv2
import numpy as np

from sdc_sim.simulation.weather import SHADOW_M_PER_M

# Fractional bits of the coordinates that OpenCV's polygon functions take.
FIXED_POINT_BITS = 4
# Unit vector to the sun.
SUN = np.array([-0.52, 0.42, 0.74])


def lattice_noise(seed: int, octave: int, size_px: int, repeats: int) -> np.ndarray:
    """Return smooth periodic noise of unit variance.

    Args:
        seed: with `octave` selects the pattern
        octave: number of the octave
        size_px: width and height of the result [px]
        repeats: periods of the pattern in the result

    Returns:
        noise (size_px, size_px) float32
    """
    lattice = (
        np.random.RandomState(seed * 1009 + octave + 64).normal(size=(32, 32)).astype(np.float32)
    )
    padded = np.pad(np.tile(lattice, (repeats, repeats)), 2, mode="wrap")
    scale = size_px // (32 * repeats)
    big = cv2.resize(padded, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)
    noise = big[2 * scale : 2 * scale + size_px, 2 * scale : 2 * scale + size_px]
    return noise / noise.std()


def touching(
    low_m: np.ndarray, high_m: np.ndarray, lower_m: np.ndarray, upper_m: np.ndarray
) -> np.ndarray:
    """Return the numbers of the boxes with corners (N, 2) that touch a rectangle."""
    return np.flatnonzero(((low_m <= upper_m) & (high_m >= lower_m)).all(axis=1))


def halve(image: np.ndarray) -> np.ndarray:
    """Return the image at half its width and height."""
    return cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)


def footprint(
    position_m: np.ndarray | Sequence[float],
    yaw_rad: float | np.ndarray,
    size_m: np.ndarray | Sequence[float],
) -> np.ndarray:
    """Return the corners (..., 4, 2) of one rectangle or of many, counter-clockwise [m].

    Args:
        position_m: x, y of its centre [m]
        yaw_rad: direction of its length [rad]
        size_m: length, width and possibly more, which is ignored [m]
    """
    size, c, s = np.asarray(size_m), np.cos(yaw_rad), np.sin(yaw_rad)
    forward = 0.5 * size[..., :1] * np.stack([c, s], axis=-1)
    left = 0.5 * size[..., 1:2] * np.stack([-s, c], axis=-1)
    sides = [forward + left, left - forward, -forward - left, forward - left]
    return np.asarray(position_m)[..., None, :] + np.stack(sides, axis=-2)


def shadow_hull(
    base_m: np.ndarray, height_m: float, shadow_m_per_m: np.ndarray = SHADOW_M_PER_M
) -> np.ndarray:
    """Return the outline (N, 2) of the shadow of a prism with the corners `base_m` (4, 2) [m]."""
    corners = np.concatenate([base_m, base_m + height_m * shadow_m_per_m])
    return cv2.convexHull(corners.astype(np.float32))[:, 0]


def blend(target: np.ndarray, sprite: np.ndarray) -> None:
    """Overlay a premultiplied BGRA sprite on a part of the picture of the same size."""
    clear = cv2.cvtColor(cv2.bitwise_not(cv2.extractChannel(sprite, 3)), cv2.COLOR_GRAY2BGRA)
    cv2.add(cv2.multiply(target, clear, scale=1.0 / 255.0), sprite, dst=target)


def dim(picture: np.ndarray, light: float) -> None:
    """Scale the brightness of a BGRA picture in place: 1 leaves it as it is, 0 makes it black."""
    if light < 1.0:
        cv2.multiply(picture, (light, light, light, 1.0), dst=picture)
