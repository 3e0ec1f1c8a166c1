"""A second reader of OpenDRIVE: the centre lines of the lanes for driving, without netconvert."""

import xml.etree.ElementTree as ElementTree

import numpy as np
from numpy.polynomial import Polynomial

_STEP_M = 0.1
_FINE_M = 0.01


def lane_centre_lines(path):
    """Return the centre lines (N, 2) of all lanes for driving, with points 0.1 m apart."""
    lines = []
    for road in ElementTree.parse(path).getroot().iter("road"):
        length = float(road.get("length"))
        sections = road.findall("lanes/laneSection")
        starts = [float(one.get("s")) for one in sections] + [length]
        for section, start, end in zip(sections, starts, starts[1:]):
            s = np.linspace(start, end, max(2, int((end - start) / _STEP_M)))
            points, heading = _reference(road, s)
            left = np.column_stack([-np.sin(heading), np.cos(heading)])
            offset = _cubics(road.findall("lanes/laneOffset"), "s", s)
            for side in ("left", "right"):
                lanes = sorted(
                    section.findall(side + "/lane"), key=lambda one: abs(int(one.get("id")))
                )
                edge = offset
                for lane in lanes:
                    width = _cubics(lane.findall("width"), "sOffset", s - start)
                    outer = edge + (width if side == "left" else -width)
                    if lane.get("type") == "driving":
                        centre = points + (0.5 * (edge + outer))[:, None] * left
                        lines.append(centre)
                    edge = outer
    return lines


def _cubics(elements, name, s):
    """Evaluate a + b t + c t^2 + d t^3 of the last element that begins at or before each s."""
    if not elements:
        return np.zeros_like(s)
    begins = np.array([float(one.get(name)) for one in elements])
    a, b, c, d = (np.array([float(one.get(key)) for one in elements]) for key in "abcd")
    row = np.clip(np.searchsorted(begins, s, side="right") - 1, 0, None)
    t = s - begins[row]
    return a[row] + t * (b[row] + t * (c[row] + t * d[row]))


def _reference(road, s):
    """Return points (N, 2) and headings (N,) of the reference line at s."""
    geometries = road.findall("planView/geometry")
    begins = np.array([float(one.get("s")) for one in geometries])
    row = np.clip(np.searchsorted(begins, s, side="right") - 1, 0, None)
    places, headings = np.empty(len(s), complex), np.empty(len(s))
    for number, geometry in enumerate(geometries):
        own = row == number
        x, y, heading, length = (float(geometry.get(key)) for key in ("x", "y", "hdg", "length"))
        local, turn = _local(geometry[0], s[own] - begins[number], length)
        places[own] = complex(x, y) + np.exp(1j * heading) * local
        headings[own] = heading + turn
    return np.column_stack([places.real, places.imag]), headings


def _local(shape, t, length):
    """Return places, complex numbers, and directions at arc lengths from the start of a shape."""
    number = {key: float(value) for key, value in shape.attrib.items() if key != "pRange"}
    s = np.linspace(0.0, length, max(2, int(length / _FINE_M)))
    if shape.tag in ("line", "arc", "spiral"):
        first = number.get("curvature", number.get("curvStart", 0.0))
        change = (number.get("curvEnd", first) - first) / length
        turn = first * s + 0.5 * change * s**2
        place = _integral(np.exp(1j * turn), s)
    else:
        if shape.tag == "poly3":
            number = {f"{key}V": number[key] for key in "abcd"}
            number.update(aU=0.0, bU=1.0, cU=0.0, dU=0.0)
        curve = Polynomial([complex(number[key + "U"], number[key + "V"]) for key in "abcd"])
        is_normalized = shape.tag == "paramPoly3" and shape.get("pRange") != "arcLength"
        p = s / length if is_normalized else s
        place, slope = curve(p), curve.deriv()(p)
        s, turn = _integral(np.abs(slope), p), np.unwrap(np.angle(slope))
    return np.interp(t, s, place), np.interp(t, s, turn)


def _integral(values, at):
    return np.append(0.0, np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(at)))
