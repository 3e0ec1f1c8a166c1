"""Mistakes that the checks of the lesson must name."""

import os
import subprocess
from pathlib import Path

import pytest

CHECK = Path(__file__).resolve().parents[2] / "check.py"


@pytest.mark.slow(2)
@pytest.mark.parametrize(
    ("first_line", "mode", "hint"),
    [
        ("#!/usr/bin/env python3", 0o644, "chmod +x"),
        ("", 0o755, "with nothing above it"),
    ],
)
def test_program_that_rosrun_cannot_start_is_explained(tmp_path, first_line, mode, hint):
    def found(chapter="3"):
        environment = {**os.environ, "HOME": str(tmp_path), "ROS_MASTER_URI": "http://127.0.0.1:1"}
        done = subprocess.run(
            [CHECK, chapter], env=environment, capture_output=True, text=True, check=False
        )
        return done.stdout, done.returncode

    assert found("12") == ("", 2)
    assert "mkdir -p ~/first_steps_ws/src" in found()[0]
    node = tmp_path / "first_steps_ws" / "src" / "world" / "scripts" / "world_node.py"
    node.parent.mkdir(parents=True)
    assert "The workspace is not built" in found()[0]
    (tmp_path / "first_steps_ws" / "devel").mkdir()
    (tmp_path / "first_steps_ws" / "devel" / "setup.bash").touch()
    node.write_text(first_line + "\nimport rospy\n")
    node.chmod(mode)
    output, status = found()
    assert (status, hint in output, "start roscore" in output) == (1, True, True), output
