"""Find on which side of the road traffic is in a file of OpenStreetMap."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterable, Iterator, List, Mapping, Tuple

import numpy as np

# Countries with traffic on the left, by their codes of ISO 3166-1.
_LEFT_COUNTRIES = (
    "AG AI AU BB BD BM BN BS BT BW CC CK CX CY DM FJ FK GB GD GG GS GY HK ID IE IM IN JE JM JP KE "
    "KI KN KY LC LK LS MO MS MT MU MV MW MY MZ NA NF NP NR NU NZ PG PK PN SB SC SG SH SR SZ TC TH "
    "TK TL TO TT TV TZ UG UK VC VG VI WS ZA ZM ZW"
)
# Tags with the code of the country of an address, and of an area.
_COUNTRY = ("addr:country", "is_in:country_code", "is_in:country", "ISO3166-1", "ISO3166-1:alpha2")
# Areas in which traffic is on the left everywhere: least and greatest latitude and longitude
# [degrees].
_LEFT_AREAS = (
    (50.05, 60.9, -10.7, 1.3),  # Great Britain and Ireland
    (51.1, 53.0, 1.3, 1.8),  # the east coast of England
    (30.0, 41.4, 131.0, 142.2),  # Japan
    (30.0, 34.0, 129.6, 131.0),  # Kyushu
    (41.4, 45.6, 139.7, 145.9),  # Hokkaido
    (-44.0, -10.0, 112.0, 154.0),  # Australia
    (-48.0, -34.0, 166.0, 179.0),  # New Zealand
    (6.0, 30.0, 70.0, 81.0),  # India
    (30.0, 35.0, 72.0, 78.5),  # the north of India and of Pakistan
    (26.0, 27.8, 81.0, 88.1),  # the plain of the Ganges, and Nepal
    (23.5, 29.8, 66.6, 70.0),  # the south of Pakistan
    (6.0, 26.0, 81.0, 92.0),  # the east of India, Sri Lanka and Bangladesh
    (12.5, 17.0, 99.7, 102.2),  # the middle of Thailand
    (-9.0, 7.0, 95.0, 116.0),  # Malaysia, Singapore and the west of Indonesia
    (-35.0, -18.1, 11.5, 36.0),  # southern Africa
    (-18.1, 3.0, 33.0, 40.9),  # eastern Africa
)

Tagged = List[Tuple[ElementTree.Element, Dict[str, str]]]


def traffic_side(
    elements: Tagged,
    streets: Tagged,
    places: Mapping[str, np.ndarray],
) -> tuple[bool, str]:
    """Return whether traffic is on the left, and by what of the file.

    Args:
        elements: nodes, ways and relations, with their tags
        streets: the ways for cars, with their tags
        places: latitude and longitude of each node with a valid place [degrees]
    """
    others = [tags for element, tags in elements if element.tag != "way"]
    lines = [_line(street, places) for street, _ in streets]
    # A few streets with this tag are those on which traffic is on the other side.
    tagged = [tags for _, tags in streets if "driving_side" in tags]
    tagged = tagged if 2 * len(tagged) >= len(streets) else []
    middle = np.mean(np.vstack(lines), axis=0)
    votes_of = {
        "by driving_side": [
            tags["driving_side"] == "left" for tags in others + tagged if "driving_side" in tags
        ],
        "by its roundabouts": [*_rotations(others, zip([tags for _, tags in streets], lines))],
        "by the country of its addresses": [
            tags[key].upper() in _LEFT_COUNTRIES
            for _, tags in elements
            for key in _COUNTRY
            if len(tags.get(key, "")) == 2
        ],
        "by its place": [
            True
            for south, north, west, east in _LEFT_AREAS
            if south < middle[0] < north and west < middle[1] < east
        ],
    }
    for reason, votes in votes_of.items():
        if 2 * sum(votes) != len(votes):
            return 2 * sum(votes) > len(votes), reason
    return False, "the file does not say"


def _line(street: ElementTree.Element, places: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return latitudes and longitudes (N, 2) of a street."""
    names = (nd.get("ref", "") for nd in street.iter("nd"))
    return np.array([places[name] for name in names if name in places]).reshape(-1, 2)


def _rotations(
    nodes: Iterable[dict[str, str]], streets: Iterable[tuple[dict[str, str], np.ndarray]]
) -> Iterator[bool]:
    """Yield for each roundabout, or part of it, whether cars go around it clockwise."""
    for tags in nodes:
        if tags.get("highway") == "mini_roundabout" and "direction" in tags:
            yield tags["direction"] == "clockwise"
    for tags, line in streets:
        is_ring = tags.get("junction") in ("roundabout", "circular")
        if is_ring and tags.get("oneway") != "no":
            north, east = (line - line[:1]).T
            # Twice the area, positive if the points are clockwise.
            area = float(np.sum(north * np.roll(east, -1) - east * np.roll(north, -1)))
            if area != 0.0:
                yield (area > 0.0) == (tags.get("oneway") != "-1")
