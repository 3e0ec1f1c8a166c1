"""Small maps for tests, and whether what reads maps is installed."""

import importlib.util
import math
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


def town(
    folder, output="-o", name="town.net.xml", mid="priority", turns="--no-turnarounds", more=()
):
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
    guesses = ["--sidewalks.guess", "--sidewalks.guess.max-speed", "20", "--crossings.guess"]
    options = ["-n", files[0], "-e", files[1], turns, "--offset.disable-normalization", *guesses]
    command = [program, *options, *more, output, path]
    subprocess.run(command, check=True, capture_output=True)
    return path


# id, start x, y and heading, shape, length, heights (place, height, slope), lane ids that follow on
# lanes -1 and 1, road that follows and the end of it that they lead to.
_RISE = ((0, 0, 0), (60, 0, 0.1), (120, 6, 0))
_FALL = ((0, 6, -6 / 471.2389),)
_LEVELS = (
    ("upper", -200, 0, 0, "<line/>", 300, _RISE, (-1, 1), "ramp", "start"),
    ("lower", 0, -200, 0.5 * math.pi, "<line/>", 300, ((0, 0, 0),), (1, -1), "ramp", "end"),
    ("ramp", 100, 0, 0, '<arc curvature="0.01"/>', 471.2389, _FALL, (1, -1), "lower", "end"),
)


def bridge(folder):
    """Write a map with two levels; return its path.

    The upper street leads along the x axis, from x -200 on: after 60 m it rises by 10 % to 6 m. At
    x 0 it crosses the lower one, which is the y axis up to y 100. A ramp joins their ends.
    """
    roads = ""
    for name, x, y, heading, shape, length, heights, lanes, follows, contact in _LEVELS:
        rows = "".join(f'<elevation s="{s}" a="{z}" b="{b}" c="0" d="0"/>' for s, z, b in heights)
        before = '<predecessor elementType="road" elementId="upper" contactPoint="end"/>'
        links = [f'<link><successor id="{one}"/></link>' for one in lanes]
        if name == "ramp":
            links = [
                one.replace("<link>", f'<link><predecessor id="{number}"/>')
                for number, one in zip((-1, 1), links)
            ]
        right, left = (
            lane(number).replace("<width", link + "<width") for number, link in zip((-1, 1), links)
        )
        roads += f"""<road name="" length="{length}" id="{name}" junction="-1"><link>
          {before if name == "ramp" else ""}
          <successor elementType="road" elementId="{follows}" contactPoint="{contact}"/></link>
          <type s="0" type="town"><speed max="50" unit="km/h"/></type>
          <planView><geometry s="0" x="{x}" y="{y}" hdg="{heading}" length="{length}">{shape}
          </geometry></planView><elevationProfile>{rows}</elevationProfile>
          <lanes><laneSection s="0"><left>{left}</left><center>{lane(0, mark="broken")}</center>
          <right>{right}</right></laneSection></lanes></road>"""
    header = '<header revMajor="1" revMinor="4" name=""/>'
    return write(folder, f"<OpenDRIVE>{header}{roads}</OpenDRIVE>", "bridge.xodr")
