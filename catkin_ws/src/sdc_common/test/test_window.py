"""A window of SDL without a display; node_manual_control.py opens a real one."""

import numpy as np
import pygame
import pytest

from sdc_common.window import ImageWindow, NoDisplay

VARIABLES = ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")
# Four rows and six columns, each value once.
PICTURE = np.arange(4 * 6 * 3, dtype=np.uint8).reshape(4, 6, 3)


@pytest.fixture
def display(monkeypatch):
    """Return a function that sets the variables from which SDL chooses a display."""

    def set_variables(**values):
        for name in VARIABLES:
            monkeypatch.setenv(name, "")
            monkeypatch.delenv(name)
        for name, value in values.items():
            monkeypatch.setenv(name, value)

    yield set_variables
    pygame.display.quit()


@pytest.fixture
def window(display):
    display(SDL_VIDEODRIVER="dummy")
    return ImageWindow("camera")


def screen():
    """Return the BGR picture on the screen."""
    return pygame.surfarray.array3d(pygame.display.get_surface()).transpose(1, 0, 2)[:, :, ::-1]


def press(key, down=True):
    pygame.event.post(pygame.event.Event(pygame.KEYDOWN if down else pygame.KEYUP, key=key))


@pytest.mark.parametrize("picture", [PICTURE, PICTURE[:3], PICTURE[:, 1:], PICTURE[:, ::-1]])
def test_window_shows_the_picture_in_its_size_and_colours(window, picture):
    for _ in range(2):
        window.show(picture)
        np.testing.assert_array_equal(screen(), picture)


def test_overlay_is_drawn_over_the_picture(window):
    window.show(PICTURE, lambda surface: surface.set_at((5, 3), (30, 20, 10)))
    expected = PICTURE.copy()
    expected[3, 5] = 10, 20, 30
    np.testing.assert_array_equal(screen(), expected)


def test_pressed_keys_are_returned_once_and_held_until_they_are_released(window):
    press(pygame.K_a)
    press(pygame.K_UP)
    assert window.show(PICTURE) == ["a", "up"]
    assert window.held == {"a", "up"}
    press(pygame.K_a, down=False)
    assert window.show(PICTURE) == []
    assert window.held == {"up"}


def test_user_closes_the_window(window):
    press(pygame.K_a)
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    press(pygame.K_b)
    assert window.show(PICTURE) == ["a"]
    assert window.closed
    assert window.held == set()
    assert not pygame.display.get_init()


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({}, "x11 not available"),
        ({"DISPLAY": ":77"}, "x11 not available"),
        ({"WAYLAND_DISPLAY": "none"}, "wayland not available"),
        ({"WAYLAND_DISPLAY": "none", "DISPLAY": ":77"}, "x11 not available"),
        ({"SDL_VIDEODRIVER": "nonsense"}, "nonsense not available"),
    ],
)
def test_missing_display_is_named(display, values, reason):
    display(**values)
    with pytest.raises(NoDisplay) as error:
        ImageWindow("camera")
    name = values.get("DISPLAY", "")
    missing = f"there is no display to open a window on (DISPLAY={name!r}): {reason}"
    assert str(error.value) == missing
    assert not pygame.display.get_init()
