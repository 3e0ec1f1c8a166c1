"""Run SUMO's programs, and keep the maps that they make in a cache.

docker/prepare maps installs them, one pinned version, beside SUMO's Python package `sumolib`.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import subprocess
import tempfile
import xml.etree.ElementTree as ElementTree
from typing import Callable, Sequence

from sdc_common.configuration import how_to_install
from sdc_common.validation import DocumentError

VERSION = "1.28.0"
# At most so much time [s] and memory [kB] for a program: some files make it take all there is.
TIMEOUT_S = 60.0
MEMORY_KB = 2_000_000
# A driver brakes after this time [s], with this deceleration [m/s^2].
_REACTS_S = 1.0
_BRAKES_MPS2 = 3.0


class MapError(DocumentError):
    """A map that cannot be used; the one-line message names file, problem and fix."""


def run(name: str, arguments: Sequence[str], file: str, about: str, fix: str) -> None:
    """Run a program of SUMO.

    Args:
        name: the program, netconvert or netgenerate
        arguments: its arguments
        file: path of a file that it writes, in the folder in which it runs
        about: the map, for the message
        fix: what a user can do if the program fails

    Raises:
        MapError: it is not installed, fails, or takes too long
    """
    sumolib = importlib.util.find_spec("sumolib")
    folder = os.path.dirname(os.path.dirname((sumolib and sumolib.origin) or ""))
    program = os.path.join(folder, "sumo", "bin", name)
    if not os.access(program, os.X_OK):
        raise MapError(f"{name} {VERSION} is missing; {how_to_install('maps')}")
    # The data of another version of SUMO, or of libsumo in this process, are not its own.
    own = {key: value for key, value in os.environ.items() if key != "SUMO_HOME"}
    try:
        done = subprocess.run(
            ["/bin/sh", "-c", f'ulimit -v {MEMORY_KB}; exec "$@"', "sh", program, *arguments],
            capture_output=True,
            text=True,
            check=False,
            cwd=os.path.dirname(file),
            env=own,
            timeout=TIMEOUT_S,
        )
    except subprocess.TimeoutExpired:
        raise MapError(f"{about}: {name} takes more than {TIMEOUT_S:g} s; {fix}") from None
    if done.returncode or not os.path.exists(file):
        raise MapError(f"{about}: {name} cannot read it: {_reason(done.stderr)}; {fix}")


def _reason(text: str) -> str:
    """Return in one line why a program ended, by what it wrote to the standard error."""
    if "bad_alloc" in text:
        return f"it needs more than {MEMORY_KB / 1e6:g} GB"
    if "No edges loaded" in text or "No nodes loaded" in text:
        return "no road has a length, and a lane for cars with a width"
    written = [line for line in text.splitlines() if not line.startswith("Warning: ")]
    errors = [line[7:] for line in written if line.startswith("Error: ")]
    lines = list(dict.fromkeys(errors or written)) or ["it ended without a reason"]
    return lines[0].rstrip(".") + (f" (and {len(lines) - 1} more)" if lines[1:] else "")


def maps_folder() -> str:
    """Return the folder of the cache."""
    root = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return os.path.join(root, "sdc_maps")


def cached(source: bytes, make: Callable[[str], None]) -> str:
    """Return the folder of the cache with what is made of a source; make it if it is not there.

    Args:
        source: all that the result depends on, besides the version of SUMO
        make: writes the files into the folder that it gets; what is beside it is not kept
    """
    key = hashlib.sha256(f"{VERSION}\n".encode() + source).hexdigest()[:32]
    folder = os.path.join(maps_folder(), key)
    if os.path.isdir(folder):
        return folder
    os.makedirs(os.path.dirname(folder), exist_ok=True)
    # A drive that is interrupted, or another one at the same time, leaves no half of a map.
    with tempfile.TemporaryDirectory(dir=os.path.dirname(folder)) as place:
        made = os.path.join(place, "made")
        os.mkdir(made)
        make(made)
        try:
            os.rename(made, folder)
        except OSError:
            if not os.path.isdir(folder):
                raise
    return folder


def lengthen_yellow(root: ElementTree.Element) -> None:
    """Let lights be yellow so long that a car at the speed limit can pass if it cannot stop.

    netconvert gives the lights of OpenDRIVE 3 s, which is enough up to 50 km/h.

    Args:
        root: the tree of SUMO's network

    Reference: D. Gazis, R. Herman and A. Maradudin, The Problem of the Amber Signal Light in
    Traffic Flow, Operations Research 8(1), 1960.
    """
    lanes = {lane.attrib["id"]: float(lane.attrib["speed"]) for lane in root.iter("lane")}
    limits_mps = {
        (way.attrib["tl"], int(way.attrib["linkIndex"])): lanes[
            f"{way.attrib['from']}_{way.attrib['fromLane']}"
        ]
        for way in root.iter("connection")
        if "tl" in way.attrib
    }
    for program in root.iter("tlLogic"):
        for phase in program.iter("phase"):
            letters = phase.attrib["state"].lower()
            yellow = [index for index, letter in enumerate(letters) if letter == "y"]
            limit_mps = max(
                (limits_mps.get((program.attrib["id"], n), 0.0) for n in yellow), default=0.0
            )
            least_s = round(_REACTS_S + limit_mps / (2.0 * _BRAKES_MPS2))
            if yellow and float(phase.attrib["duration"]) < least_s:
                phase.set("duration", str(least_s))
