import os
import shutil
import subprocess

import pytest

from sdc_testing.virtual_display import VirtualDisplay


def test_picture_has_the_size_of_the_screen_and_the_colour_of_its_root():
    before = os.environ.get("DISPLAY")
    with VirtualDisplay(320, 240) as display:
        assert os.environ.get("DISPLAY") == before
        assert display.picture().shape == (240, 320, 3)
        assert display.windows("none") == []
        command = ["xdpyinfo"] if shutil.which("xdpyinfo") else ["xdotool", "getmouselocation"]
        subprocess.run(command, env=display.environment, check=True, stdout=subprocess.DEVNULL)
    with pytest.raises(OSError):
        display.picture()


def test_two_displays_run_at_the_same_time():
    with VirtualDisplay(320, 240) as one, VirtualDisplay(200, 100) as two:
        assert one.environment["DISPLAY"] != two.environment["DISPLAY"]
        assert two.picture().shape == (100, 200, 3)


def test_missing_xvfb_is_an_error_that_names_it(monkeypatch):
    monkeypatch.setenv("PATH", "/none")
    with pytest.raises(FileNotFoundError, match="Xvfb"), VirtualDisplay():
        pass
