"""A second reader of OpenDRIVE: the centre lines of the lanes for driving, without netconvert."""

import xml.etree.ElementTree as ElementTree

import numpy as np

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
    points, headings = np.empty((len(s), 2)), np.empty(len(s))
    for number, geometry in enumerate(geometries):
        own = row == number
        if not own.any():
            continue
        x, y, heading, length = (float(geometry.get(key)) for key in ("x", "y", "hdg", "length"))
        u, v, turn = _local(geometry[0], s[own] - begins[number], length)
        c, sin = np.cos(heading), np.sin(heading)
        points[own] = np.column_stack([x + c * u - sin * v, y + sin * u + c * v])
        headings[own] = heading + turn
    return points, headings


def _local(shape, t, length):
    """Return u, v and the angle of a shape at arc lengths t from its start."""
    number = {key: float(value) for key, value in shape.attrib.items() if key != "pRange"}
    if shape.tag == "line":
        return t, np.zeros_like(t), np.zeros_like(t)
    if shape.tag in ("arc", "spiral"):
        first = number.get("curvature", number.get("curvStart"))
        last = number.get("curvature", number.get("curvEnd"))
        fine = np.linspace(0.0, length, max(2, int(length / _FINE_M)))
        turn = first * fine + 0.5 * (last - first) / length * fine**2
        u, v = (_integral(part, fine) for part in (np.cos(turn), np.sin(turn)))
    elif shape.tag == "poly3":
        u = np.linspace(0.0, length, max(2, int(length / _FINE_M)))
        a, b, c, d = (number[key] for key in "abcd")
        v = a + u * (b + u * (c + u * d))
        fine, turn = (
            _integral(np.hypot(1.0, b + u * (2 * c + 3 * u * d)), u),
            np.arctan(b + u * (2 * c + 3 * u * d)),
        )
    else:
        p = np.linspace(
            0.0,
            length if shape.get("pRange") == "arcLength" else 1.0,
            max(2, int(length / _FINE_M)),
        )
        u, v = (sum(number[key + axis] * p**k for k, key in enumerate("abcd")) for axis in "UV")
        du, dv = (
            sum(k * number[key + axis] * p ** (k - 1) for k, key in enumerate("abcd") if k)
            for axis in "UV"
        )
        fine, turn = _integral(np.hypot(du, dv), p), np.unwrap(np.arctan2(dv, du))
    return tuple(np.interp(t, fine, part) for part in (u, v, turn))


def _integral(values, at):
    return np.append(0.0, np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(at)))
