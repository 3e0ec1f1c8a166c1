import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds

THRESHOLDS = LaneFilterThresholds(gradient=70, saturation=90, lightness=110, horizon_fraction=0.5)


def road(lines=((200, (255, 255, 255)), (400, (0, 200, 230)))):
    picture = np.full((480, 640, 3), 90, np.uint8)
    for x, colour in lines:
        cv2.line(picture, (x, 240), (x, 479), colour, 8)
    return picture


def test_mask_contains_white_and_yellow_lines():
    mask = LaneFilter(THRESHOLDS).mask(road())
    assert mask.shape == (480, 640)
    assert set(np.unique(mask)) == {0, 255}
    columns = np.flatnonzero(mask[300:].any(axis=0))
    assert np.abs(columns[:, None] - [200, 400]).min(axis=1).max() <= 6
    assert {200 - 4, 400} <= set(columns)
    assert mask[300:, 396:404].mean() > 200, "the filter fills a coloured line"


def test_mask_is_empty_above_the_horizon():
    picture = road()
    picture[:240, ::20] = 255
    assert not LaneFilter(THRESHOLDS).mask(picture)[:240].any()


def test_brightness_does_not_change_the_mask():
    noon = road(lines=((200, (255, 255, 255)),))
    dusk = (noon // 3).astype(np.uint8)
    mask = LaneFilter(THRESHOLDS).mask
    np.testing.assert_array_equal(mask(dusk), mask(noon))


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((480, 640), np.uint8),
        np.zeros((480, 640, 3)),
        np.zeros((0, 640, 3), np.uint8),
        np.zeros((4, 4, 2), np.uint8),
    ],
)
def test_array_that_is_no_picture_is_refused(image):
    with pytest.raises(ValueError, match="expected"):
        LaneFilter(THRESHOLDS).mask(image)


@pytest.mark.parametrize(
    "wrong", [{"gradient": -1}, {"saturation": 256}, {"lightness": 1000}, {"horizon_fraction": 1.0}]
)
def test_thresholds_out_of_range_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        LaneFilterThresholds(**{**vars(THRESHOLDS), **wrong})


@given(
    hnp.arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9), st.sampled_from([3, 4])))
)
def test_mask_is_binary_and_has_the_size_of_the_picture(image):
    mask = LaneFilter(THRESHOLDS).mask(image)
    assert (mask.shape, mask.dtype) == (image.shape[:2], np.uint8)
    assert set(np.unique(mask)) <= {0, 255}
