"""Overlap and first contact of rectangles: exact, with the shortest way out, and no tunnelling."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sdc_sim.physics.collision import Rectangle, first_contact, overlap

UNIT = Rectangle(0, 0, 0, 2, 2)


@pytest.mark.parametrize(
    ("a", "b", "depth_m", "normal"),
    [
        (Rectangle(0, 0, 0, 2, 2), Rectangle(1.5, 0, 0, 2, 2), 0.5, (-1.0, 0.0)),
        (Rectangle(0, 1.75, 0, 4, 2), Rectangle(0, 0, math.pi, 4, 2), 0.25, (0.0, 1.0)),
        (Rectangle(0, 0, 0, 2, 2), Rectangle(2.0, 0, 0, 2, 2), None, None),
        (UNIT, Rectangle(2.3, 0, math.pi / 4, 2, 2), 1 + math.sqrt(2) - 2.3, (-1.0, 0.0)),
        (Rectangle(0, 0, 0, 2, 2), Rectangle(2.0, 2.0, math.pi / 4, 2, 2), None, None),
        (Rectangle(0, 0, 0, 2, 2, 6), Rectangle(1.5, 0, 0, 2, 2, 0), None, None),
        (Rectangle(0, 0, 0, 2, 2, 2), Rectangle(1.5, 0, 0, 2, 2, 0), 0.5, (-1.0, 0.0)),
        (Rectangle(0, 0, 0, 2, 2), Rectangle(1.5, 0, 0, 2, 2, 6), 0.5, (-1.0, 0.0)),
    ],
)
def test_overlap_has_known_depth_and_normal(a, b, depth_m, normal):
    found = overlap(a, b)
    if depth_m is None:
        assert found is None
    else:
        assert found == pytest.approx((depth_m, *normal))


@settings(deadline=None)
@given(*map(st.floats, (-math.pi, 10.0, -2.0, 0.1), (math.pi, 60.0, 2.0, 0.6)))
def test_no_motion_is_too_fast_and_no_body_too_thin(heading, distance_m, aside_m, thickness_m):
    """A car crosses the origin in one motion; a thin body there stops it before the contact."""
    c, s = math.cos(heading), math.sin(heading)

    def motion(share):
        along = (share - 0.5) * distance_m
        return Rectangle(along * c, along * s, heading, 4.7, 2.0)

    place = -aside_m * 0.4 * s, aside_m * 0.4 * c, heading + 0.3
    other = Rectangle(*place, thickness_m, thickness_m)
    if overlap(motion(0.0), other):
        return
    contact = first_contact(motion, lambda _: other)
    assert contact is not None
    assert overlap(motion(contact.share), other) is None
    assert overlap(motion(min(1.0, contact.share + 1e-6)), other)
    assert contact.normal_x * c + contact.normal_y * s < 0.0


@pytest.mark.parametrize(
    ("way_m", "contact"), [(0.5, (0.0, -1.0, 0.0)), (-0.5, None), (-0.1, None), (3.5, None)]
)
def test_body_that_overlaps_another_may_only_move_out(way_m, contact):
    def motion(share):
        return Rectangle(way_m * share, 0.0, 0.0, 2.0, 2.0)

    found = first_contact(motion, lambda _: Rectangle(1.5, 0.0, 0.0, 2.0, 2.0))
    assert found == contact
