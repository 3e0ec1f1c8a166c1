"""Routes for the tests, and a function that drives them without ROS."""

import math
import tempfile
from pathlib import Path

import yaml

from driverless.driver import Driver
from world.rules import checked
from world.rules import read_settings as read_world_settings
from world.simulation import Simulation

PACKAGES = Path(__file__).resolve().parents[2]


def around(radius, count=30, turns=1):
    """Return points on a curve around the origin; `radius` maps an angle to a distance."""
    angles = [2.0 * math.pi * turns * i / count for i in range(count)]
    return [(radius(a) * math.cos(a), radius(a) * math.sin(a)) for a in angles]


def along(corners, spacing=50.0):
    """Return points about `spacing` apart on the closed polygon with these corners."""
    points = []
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1]):
        pieces = max(1, round(math.hypot(x1 - x0, y1 - y0) / spacing))
        points += [
            (x0 + (x1 - x0) * i / pieces, y0 + (y1 - y0) * i / pieces) for i in range(pieces)
        ]
    return points


SHAPES = {
    "ellipse": [
        (350 * math.cos(math.pi * i / 15), 150 * math.sin(math.pi * i / 15)) for i in range(30)
    ],
    "circle": around(lambda a: 160),
    "clockwise circle": around(lambda a: 160)[::-1],
    "rectangle to the corners": along([(400, 225), (-400, 225), (-400, -225), (400, -225)]),
    "triangle": along([(0, 180), (-250, -150), (250, -150)]),
    "figure eight": [
        (330 * math.sin(a), 170 * math.sin(2 * a))
        for a in [2 * math.pi * i / 36 for i in range(36)]
    ],
    "clover": around(lambda a: 120 + 80 * math.cos(4 * a), count=40),
    "there and back": along([(-350, 0), (350, 0)]),
    "spiral": [
        (40 * a * math.cos(a) / math.pi, 40 * a * math.sin(a) / math.pi)
        for a in [math.pi / 4 * i for i in range(1, 20)]
    ],
    "two points": [(-300, 100), (300, -100)],
}


def packaged(package, **overrides):
    """Return the parameters in the package's config file, with overrides."""
    text = (PACKAGES / package / "config" / f"{package}.yaml").read_text()
    return {**yaml.safe_load(text), **overrides}


def drive(points, start, world=None, driver=None, laps=1, delay=0, step_limit=6000):
    """Drive from `start` (x, y, direction) until `laps` are completed.

    `delay` is the number of ticks by which a command arrives late. Return the number of steps, or
    None if it exceeds `step_limit`.
    """
    with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
        file.write("x,y\n" + "".join(f"{x},{y}\n" for x, y in points))
        file.flush()
        settings = read_world_settings(packaged("world", waypoints_path=file.name, **(world or {})))
        simulation = Simulation(settings)
    simulation.place_car(*start)
    driver_settings = checked("driverless", packaged("driverless", **(driver or {})))
    student = Driver(driver_settings)
    if driver_settings.use_map:
        student.set_map(simulation.waypoints)
    pending = [0.0] * delay
    for step in range(step_limit):
        student.set_sensed(simulation.sensed())
        pending.append(student.step(*simulation.car)[0])
        simulation.steer(pending.pop(0))
        simulation.tick(1.0 / settings.rate)
        if simulation.lap_counter.laps >= laps:
            return step + 1
    return None
