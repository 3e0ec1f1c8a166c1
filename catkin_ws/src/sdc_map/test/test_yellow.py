"""Lights are yellow so long that a car at the limit can pass if it cannot stop."""

import xml.etree.ElementTree as ElementTree

import pytest

from sdc_map.sumo_programs import lengthen_yellow

NETWORK = """<net>
 <edge id="a"><lane id="a_0" speed="{limit}"/></edge><edge id="b"><lane id="b_0" speed="8"/></edge>
 <tlLogic id="t"><phase duration="30" state="Gr"/><phase duration="3" state="yr"/>
  <phase duration="30" state="rG"/><phase duration="3" state="ry"/></tlLogic>
 <connection from="a" to="c" fromLane="0" toLane="0" tl="t" linkIndex="0"/>
 <connection from="b" to="c" fromLane="0" toLane="0" tl="t" linkIndex="1"/>
</net>"""


@pytest.mark.parametrize(("limit", "seconds"), [(8.0, 3.0), (13.9, 3.0), (24.6, 5.0), (29.1, 6.0)])
def test_yellow_is_as_long_as_the_limit_of_its_own_way_needs(limit, seconds):
    root = ElementTree.fromstring(NETWORK.format(limit=limit))
    lengthen_yellow(root)
    phases = root.iter("phase")
    assert [float(one.attrib["duration"]) for one in phases] == [30.0, seconds, 30.0, 3.0]
