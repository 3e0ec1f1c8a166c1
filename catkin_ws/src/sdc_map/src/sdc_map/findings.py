"""What a file has and the map that is read from it does not have, or has otherwise."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Iterator, NamedTuple, Optional, Tuple

Point = Optional[Tuple[float, float]]


class FilePlace(NamedTuple):
    """A place in a file."""

    text: str  # by which a person finds it, such as "road 7 at 30 m"
    point_m: Point  # x and y in the map, None if they are unknown [m]


@dataclass
class Findings:
    """Places by kind of thing, to which all readers of a file add."""

    places: dict[str, list[FilePlace]] = field(default_factory=dict)
    side: str = ""  # by what of the file traffic is on its side, "" if the format says it

    def add(self, kind: str, text: str, point_m: Point = None) -> None:
        """Add a place of a kind of thing; see FilePlace."""
        self.places.setdefault(kind, []).append(FilePlace(text, point_m))

    def lines(self) -> Iterator[str]:
        """Yield a line for each kind, with the number of its places and the first one."""
        for kind, places in self.places.items():
            yield f"{kind} ({len(places)}, the first: {places[0].text})"
