import math

import numpy as np
import pytest

from sdc_common.geometry.smoothing_spline import SmoothingSpline

STEP_M, WIDTH_M = 0.4, 4.0
# No deviation is significant in this noise.
NO_BEND_M = 1e6


def steps(length_m, spacing_m, start_m=0.0):
    return start_m + spacing_m * np.arange(int(round(length_m / spacing_m)) + 1)


@pytest.mark.parametrize("width_m", [1.0, 10.0])
@pytest.mark.parametrize("spacing_m", [0.5, 2.0])
@pytest.mark.parametrize("start_m", [0.0, 30.0, -30.0])
def test_parabola_is_kept_at_any_place(start_m, spacing_m, width_m):
    """Its third derivative is zero."""

    def parabola(s):
        t = s - start_m
        return np.column_stack([1e5 + t - 0.01 * t * t, -7e6 + 0.02 * t * t])

    s = steps(40.0, spacing_m, start_m)
    spline = SmoothingSpline(s, parabola(s), spacing_m, NO_BEND_M, width_m)
    between = start_m + np.linspace(0.0, 40.0, 97)
    np.testing.assert_allclose(spline(between), parabola(between), rtol=0.0, atol=1e-6)
    assert spline.widths_m.tolist() == [width_m] * 40


@pytest.mark.parametrize("start_m", [0.0, -50.0])
@pytest.mark.parametrize("spacing_m", [0.5, 2.0])
@pytest.mark.parametrize(("width_m", "wavelength_m"), [(3.0, 20.0), (3.0, 30.0), (5.0, 30.0)])
def test_wave_is_damped_by_the_law_of_the_penalty(width_m, wavelength_m, spacing_m, start_m):
    """The spline minimizes deviation^2 + width^6 * (third derivative)^2."""
    number = 2.0 * math.pi / wavelength_m
    s = steps(200.0, spacing_m, start_m)
    middle_m = start_m + 100.0
    points = np.column_stack([s, np.cos(number * (s - middle_m))])
    spline = SmoothingSpline(s, points, spacing_m, NO_BEND_M, width_m)
    expected = 1.0 / (1.0 + (number * width_m) ** 6)
    assert spline(np.array([middle_m]))[0].tolist() == pytest.approx([middle_m, expected], rel=5e-3)


@pytest.mark.parametrize("column", [0, 1])
@pytest.mark.parametrize("start_m", [0.0, 20.0])
@pytest.mark.parametrize(("noise", "narrow"), [(1.01, range(0)), (0.99, range(46, 55))])
def test_width_is_reduced_where_the_mean_deviation_is_significant(noise, narrow, start_m, column):
    """Half of this wave remains: the points at its crest deviate by the other half.

    Their mean over two widths is significant if it exceeds 3.5 standard errors.
    """
    s = steps(100.0, STEP_M, start_m)
    points = np.column_stack([s, s])
    points[:, column] = np.cos((s - start_m - 50.5) / WIDTH_M)
    mean_m = 0.5 * math.sin(1.0)
    noise_m = noise * mean_m * math.sqrt(2.0 * WIDTH_M / STEP_M) / 3.5
    widths_m = SmoothingSpline(s, points, STEP_M, noise_m, WIDTH_M).widths_m
    expected = [0.8 * WIDTH_M if i in narrow else WIDTH_M for i in range(100)]
    assert widths_m.tolist() == expected
