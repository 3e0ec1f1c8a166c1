"""Lines in machine code have the numbers of plain ones."""

import numpy as np
import pytest

from sdc_common.geometry import segments
from sdc_common.geometry.polyline import Polyline

pytestmark = pytest.mark.slow(3)


def test_compiled_line_equals_a_plain_one_bit_for_bit(monkeypatch):
    pytest.importorskip("numba")
    monkeypatch.setattr(segments, "_in_machine_code", False)
    random = np.random.default_rng(5)
    walks = []
    for count, extend in ((2, True), (3, False), (40, True), (40, False), (300, False)):
        steps = random.normal(size=(count, 2))  # the line turns around itself
        steps[5:7] = 0.0  # two points repeat the one before them
        points = [tuple(row) for row in np.cumsum(steps, axis=0).tolist()]
        walks.append((points, extend, Polyline(points, extend)))
    segments.use_machine_code()
    for points, extend, plain in walks:
        compiled = Polyline(points, extend)
        assert compiled.numbers.are_arrays
        assert not plain.numbers.are_arrays
        for name in ("lengths", "s", "headings"):
            assert getattr(compiled, name) == getattr(plain, name)
        plain.headings = compiled.headings = [0.9 * heading for heading in plain.headings]
        assert compiled.numbers.headings.tolist() == plain.headings
        for _ in range(50):
            point = random.normal(scale=5.0, size=2).tolist()
            first = int(random.integers(len(plain.lengths)))
            for window in ((), (first, first + 5)):
                # repr shows the sign of a zero, and NaN equals itself.
                assert repr(compiled.nearest(*point, *window)) == repr(
                    plain.nearest(*point, *window)
                )
        assert repr(compiled.nearest(np.nan, 0.0)) == repr(plain.nearest(np.nan, 0.0))
