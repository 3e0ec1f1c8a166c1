"""Mistakes that the checks of the lesson must name."""

import os
import subprocess
from pathlib import Path

import pytest

CHECK = Path(__file__).resolve().parents[2] / "check.py"


def check(home, *chapters):
    return subprocess.run(
        [CHECK, *chapters],
        env={**os.environ, "HOME": str(home), "ROS_MASTER_URI": "http://127.0.0.1:1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=60,
        check=False,
    )


@pytest.mark.parametrize(
    ("first_line", "mode", "hint"),
    [
        ("#!/usr/bin/env python3", 0o644, "chmod +x"),
        ("", 0o755, "with nothing above it"),
        (None, 0, "The file is src/world"),
    ],
)
def test_program_that_rosrun_cannot_start_is_explained(tmp_path, first_line, mode, hint):
    found = check(tmp_path, "3")
    assert (found.returncode, "mkdir -p ~/first_steps_ws/src" in found.stdout) == (1, True)
    node = tmp_path / "first_steps_ws" / "src" / "world" / "scripts" / "world_node.py"
    node.parent.mkdir(parents=True)
    assert "The workspace is not built" in check(tmp_path, "3").stdout
    (tmp_path / "first_steps_ws" / "devel").mkdir()
    (tmp_path / "first_steps_ws" / "devel" / "setup.bash").touch()
    if first_line is not None:
        node.write_text(first_line + "\nimport rospy\n")
        node.chmod(mode)
    found = check(tmp_path, "3")
    assert (found.returncode, hint in found.stdout) == (1, True), found.stdout
    assert "start roscore" in found.stdout, "the topic is checked, too"


def test_unknown_chapter_is_refused(tmp_path):
    for chapters in ((), ("12",), ("always",)):
        assert check(tmp_path, *chapters).returncode == 2
