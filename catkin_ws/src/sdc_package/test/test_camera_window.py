"""What the camera window shows, without a display; node_camera_window.py opens a real one."""

import numpy as np
import pytest
import rospy

from sdc_package.camera_window import CameraWindow

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


def test_key_q_closes_the_window_and_other_keys_change_nothing():
    window = CameraWindow(True, False)
    assert not window.press("q")
    assert window.press("x")
    window.update(IMAGE, MASK)
    assert shown(window) == (10, 20, 30)


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
