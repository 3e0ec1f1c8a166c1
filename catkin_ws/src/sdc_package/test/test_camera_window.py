"""What the camera window shows, without a display."""

import numpy as np
import pygame
import pytest
import rospy

from sdc_package.camera_window import TITLE, CameraWindow

IMAGE = np.full((4, 6, 4), (10, 20, 30, 255), np.uint8)
MASK = np.full((4, 6), 255, np.uint8)


def shown(window):
    return tuple(window.picture[0, 0])


@pytest.mark.parametrize(("show_mask", "colour"), [(False, (10, 20, 30)), (True, (255, 255, 255))])
def test_window_starts_with_the_picture_or_the_mask(show_mask, colour):
    window = CameraWindow(True, show_mask)
    assert window.picture is None
    window.update(IMAGE, MASK)
    assert window.picture.shape == (4, 6, 3)
    assert shown(window) == colour


def test_key_f_switches_between_picture_and_mask():
    window = CameraWindow(True, False)
    for colour in ((255, 255, 255), (10, 20, 30)):
        assert window.press("f")
        window.update(IMAGE, MASK)
        assert shown(window) == colour


def test_disabled_window_keeps_no_picture_and_returns_at_once():
    window = CameraWindow(False, False)
    window.update(IMAGE, MASK)
    assert window.picture is None
    window.run()


def test_window_without_a_display_logs_the_reason_and_is_disabled(monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)
    warnings = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *args: warnings.append(text % args))
    window = CameraWindow(True, False)
    window.run()
    assert len(warnings) == 1
    assert warnings[0].startswith("camera: there is no display")
    assert warnings[0].endswith("continuing without a window")
    window.update(IMAGE, MASK)
    assert window.picture is None


def test_window_shows_the_picture_until_key_q(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")  # an invisible window
    shown_at_keys = []

    class Watched(CameraWindow):
        def press(self, key):
            colour = tuple(pygame.display.get_surface().get_at((0, 0)))[:3]
            shown_at_keys.append((key, colour, pygame.display.get_caption()[0]))
            if key == "x":
                pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=pygame.K_q))
            return super().press(key)

    window = Watched(True, False)
    window.update(IMAGE, MASK)
    pygame.display.init()
    pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=pygame.K_x))
    window.run()
    assert shown_at_keys == [("x", (30, 20, 10), TITLE), ("q", (30, 20, 10), TITLE)]
    assert not pygame.display.get_init()
    window.update(MASK, MASK)
    assert shown(window) == (10, 20, 30)
