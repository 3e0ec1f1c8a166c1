"""Small maps for tests, and whether what reads maps is installed."""

import importlib.util
import os
import subprocess

import numpy as np
import pytest

from sdc_common.geometry.road_line import arc_lengths
from sdc_common.geometry.route import interpolate

is_installed = importlib.util.find_spec("sumolib") is not None
needs_maps = pytest.mark.skipif(not is_installed, reason="docker/prepare maps has not been run")
has_libsumo = is_installed and importlib.util.find_spec("libsumo") is not None
needs_traffic = pytest.mark.skipif(not has_libsumo, reason="docker/prepare traffic: not run")

_WIDTH = '<width sOffset="0" a="{}" b="{}" c="0" d="0"/>'
_LANE = '<lane id="{}" type="{}">{}<roadMark sOffset="0" type="{}"/></lane>'


def lane(number, width=(3.5, 0.0), kind="driving", mark="solid"):
    """Return a lane of OpenDRIVE; a width is that at the start and its growth per metre."""
    return _LANE.format(number, kind, _WIDTH.format(*width) if number else "", mark)


def opendrive(shape, length, right, left="", offset="", header=""):
    """Return a map of one road with this shape from (10, -4) at 0.3 rad."""
    return f"""<OpenDRIVE><header revMajor="1" revMinor="4" name="">{header}</header>
      <road name="" length="{length}" id="7" junction="-1"><link/>
        <type s="0" type="town"><speed max="30" unit="km/h"/></type>
        <planView><geometry s="0" x="10" y="-4" hdg="0.3" length="{length}">{shape}</geometry>
        </planView>
        <lanes>{offset}<laneSection s="0"><left>{left}</left>
          <center>{lane(0, mark="solid solid")}</center><right>{right}</right>
        </laneSection></lanes></road></OpenDRIVE>"""


def dense(points: np.ndarray) -> np.ndarray:
    """Return points (M, 2) along a line (N, 2) that are 0.02 m apart [m]."""
    s = arc_lengths(points)
    return interpolate(np.linspace(0.0, s[-1], int(s[-1] / 0.02) + 2), s, points)


def write(folder, text, name="map.xodr"):
    """Write a map; return its path."""
    path = os.path.join(str(folder), name)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


# id, x, y and type of the junctions; id, ends, lanes and speed of the streets.
_NODES = (
    ("mid", 0, 0, "priority"),
    ("light", 120, 0, "traffic_light"),
    ("west", -150, 0, "priority"),
    ("north", 0, 120, "priority"),
    ("south", 0, -120, "priority"),
    ("east", 260, 0, "priority"),
    ("up", 120, 120, "priority"),
)
_STREETS = (
    ("a", "west", "mid", 2, 14.0),
    ("b", "mid", "light", 2, 14.0),
    ("c", "light", "east", 1, 14.0),
    ("d", "north", "mid", 1, 8.0),
    ("e", "mid", "south", 1, 8.0),
    ("f", "light", "up", 1, 8.0),
)


def town(folder, output="-o", name="town.net.xml", mid="priority", turns="--no-turnarounds"):
    """Make a small town of two junctions with netconvert; return the path of its map.

    The street a-b-c from west to east has priority at `mid`, of this type, and a light at `light`.
    """
    nodes = "".join(
        f'<node id="{i}" x="{x}" y="{y}" type="{mid if i == "mid" else kind}"/>'
        for i, x, y, kind in _NODES
    )
    edges = "".join(
        f'<edge id="{sign}{i}" from="{start}" to="{end}" numLanes="{lanes}" speed="{speed}" '
        f'priority="{3 if i in "abc" else 1}"/>'
        for i, one, other, lanes, speed in _STREETS
        for sign, start, end in (("", one, other), ("-", other, one))
    )
    files = [
        write(folder, f"<{kind}>{text}</{kind}>", f"town.{kind}.xml")
        for kind, text in (("nodes", nodes), ("edges", edges))
    ]
    path = os.path.join(str(folder), name)
    sumolib = importlib.util.find_spec("sumolib").origin
    program = os.path.join(os.path.dirname(os.path.dirname(sumolib)), "sumo", "bin", "netconvert")
    options = ["-n", files[0], "-e", files[1], turns, "--offset.disable-normalization"]
    subprocess.run(
        [
            program,
            *options,
            "--sidewalks.guess",
            "--sidewalks.guess.max-speed",
            "20",
            "--crossings.guess",
            output,
            path,
        ],
        check=True,
        capture_output=True,
    )
    return path
