"""What all painters of the camera picture share: the air, the shadows, and a few strokes."""

from __future__ import annotations

import cv2
import numpy as np

FIXED_POINT_BITS = 4
HAZE_BGR = np.array([214.0, 202.0, 190.0])
HAZE_RANGE_M = 420.0
SHADOW_M_PER_M = np.array([0.55, -0.45])  # shadow of a thing one metre high
SHADE = 0.58


def lattice_noise(seed: int, octave: int, size_px: int, repeats: int) -> np.ndarray:
    """Smooth periodic noise (size_px, size_px) of unit variance; equal seed and octave give the same pattern."""
    lattice = (
        np.random.RandomState(seed * 1009 + octave + 64).normal(size=(32, 32)).astype(np.float32)
    )
    padded = np.pad(np.tile(lattice, (repeats, repeats)), 2, mode="wrap")
    scale = size_px // (32 * repeats)
    big = cv2.resize(padded, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)
    noise = big[2 * scale : 2 * scale + size_px, 2 * scale : 2 * scale + size_px]
    return noise / noise.std()


def halve(image: np.ndarray) -> np.ndarray:
    return cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)


def footprint(position, yaw_rad: float, size) -> np.ndarray:
    """Corners (4, 2) of a rectangle, counter-clockwise."""
    forward = 0.5 * size[0] * np.array([np.cos(yaw_rad), np.sin(yaw_rad)])
    left = 0.5 * size[1] * np.array([-np.sin(yaw_rad), np.cos(yaw_rad)])
    return np.asarray(position) + np.stack(
        [forward + left, left - forward, -forward - left, forward - left]
    )


def blend(part: np.ndarray, sprite: np.ndarray) -> None:
    """Lay a premultiplied BGRA sprite over a part of the picture."""
    clear = cv2.cvtColor(cv2.bitwise_not(cv2.extractChannel(sprite, 3)), cv2.COLOR_GRAY2BGRA)
    cv2.add(cv2.multiply(part, clear, scale=1.0 / 255.0), sprite, dst=part)


def dim(picture: np.ndarray, light: float) -> None:
    """Scale the brightness of a BGRA picture, in place: 1 leaves it as it is, 0 makes it black."""
    if light < 1.0:
        cv2.multiply(picture, (light, light, light, 1.0), dst=picture)
