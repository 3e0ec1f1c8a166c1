"""Find the file of a map by the name that a user gives."""

from __future__ import annotations

import os
import re

from sdc_common.configuration import package_folder
from sdc_map.random_town import random_town
from sdc_map.sumo_programs import MapError

# A town that is drawn: random:SEED. Without its seed, it is drawn from the seed of the drive.
RANDOM = "random"


def map_file(name: str, folder: str = "", seed: int | None = None) -> str:
    """Return the path of a map: of a packaged one, of a town that is drawn, or of a file.

    Args:
        name: what the user gives
        folder: folder of a file with a relative path
        seed: seed of the drive, for the map "random"; None if there is none

    Raises:
        MapError: the seed of a town is missing or not valid, or the town cannot be drawn
    """
    if name == RANDOM and seed is not None:
        name = f"{RANDOM}:{seed}"
    if name.partition(":")[0] == RANDOM:
        if not re.fullmatch(RANDOM + r":\d{1,10}", name):
            raise MapError(f"{name}: is not one town; write {RANDOM}:SEED, such as {RANDOM}:7")
        options = os.path.join(packaged_maps(), "town", "town.netccfg")
        return random_town(int(name.partition(":")[2]), options)
    packaged = os.path.join(packaged_maps(), name + ".net.xml")
    if name.isidentifier() and os.path.exists(packaged):
        return os.path.abspath(packaged)
    return os.path.abspath(os.path.join(folder, os.path.expanduser(name)))


def town_seeds(name: str) -> list[int]:
    """Return the seeds of a set of towns, random:FIRST-LAST; none of another map.

    Raises:
        MapError: the set is empty
    """
    found = re.fullmatch(RANDOM + r":(\d{1,10})-(\d{1,10})", name)
    seeds = list(range(int(found[1]), int(found[2]) + 1)) if found else []
    if found and not seeds:
        raise MapError(f"{name}: has no town; write {RANDOM}:FIRST-LAST, such as {RANDOM}:1-20")
    return seeds


def packaged_maps() -> str:
    """Return the folder of the packaged maps."""
    return os.path.join(package_folder("sdc_map"), "maps")
