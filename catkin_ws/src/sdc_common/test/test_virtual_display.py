import os
import shutil
import subprocess

import pytest

from sdc_common.virtual_display import VirtualDisplay


def test_picture_has_the_size_of_the_screen_and_the_colour_of_its_root():
    before = os.environ.get("DISPLAY")
    with VirtualDisplay(320, 240) as display:
        assert os.environ.get("DISPLAY") == before
        assert display.picture().shape == (240, 320, 3)
        assert display.windows("none") == []
        command = ["xdpyinfo"] if shutil.which("xdpyinfo") else ["xdotool", "getmouselocation"]
        subprocess.run(command, env=display.environment, check=True, stdout=subprocess.DEVNULL)
    with pytest.raises(LookupError):
        display.picture()


def test_windows_that_change_while_they_are_read_are_read_again(tmp_path):
    with VirtualDisplay(320, 240) as display:
        changed = tmp_path / "changed"
        command = tmp_path / "xwd"
        command.write_text(
            f"#!/bin/sh\n[ -e {changed} ] || {{ touch {changed}; echo BadMatch >&2; exit 1; }}\n"
            f'exec {shutil.which("xwd")} "$@"\n',
            encoding="utf-8",
        )
        command.chmod(0o755)
        display.environment["PATH"] = f"{tmp_path}:{os.environ['PATH']}"
        assert display.picture().shape == (240, 320, 3)
        assert changed.exists()


def test_two_displays_run_at_the_same_time():
    with VirtualDisplay(320, 240) as one, VirtualDisplay(200, 100) as two:
        assert one.environment["DISPLAY"] != two.environment["DISPLAY"]
        assert two.picture().shape == (100, 200, 3)


def test_missing_xvfb_is_an_error_that_names_it(monkeypatch):
    monkeypatch.setenv("PATH", "/none")
    with pytest.raises(FileNotFoundError, match="Xvfb"), VirtualDisplay():
        pass
