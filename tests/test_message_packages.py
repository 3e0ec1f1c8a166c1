"""Of CARLA's message packages, those that are installed are used."""

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def found(prefix):
    """Return what the build leaves out while packages are installed below this folder."""
    return subprocess.run(
        ["bash", "-c", ". docker/environment; NOETIC=; installed_message_packages"],
        cwd=ROOT,
        env={**os.environ, "CMAKE_PREFIX_PATH": str(prefix)},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    ).stdout


def test_build_uses_an_installed_package_instead_of_the_own_one(tmp_path):
    before = found(tmp_path)
    config = tmp_path / "share" / "carla_msgs" / "cmake" / "carla_msgsConfig.cmake"
    config.parent.mkdir(parents=True)
    config.touch()
    assert "carla_msgs;" in found(tmp_path)
    assert found(tmp_path).replace("carla_msgs;", "") == before.replace("carla_msgs;", "")


def test_own_packages_count_as_not_installed():
    devel = ROOT / "catkin_ws" / "devel"
    assert (devel / "share" / "carla_msgs" / "cmake" / "carla_msgsConfig.cmake").exists()
    assert found(devel) == found(ROOT)
