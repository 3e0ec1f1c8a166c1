"""The packaged vehicles."""

import dataclasses
import os
from pathlib import Path

from sdc_sim.physics.vehicle_parameters import load_vehicle
from sdc_sim.scenario.packaged import folder_of

FOLDER = folder_of("vehicle")
PRESETS = sorted(path.stem for path in Path(FOLDER).glob("*.yaml"))


def preset(name="tesla_model3", **changes):
    """Return the parameters of a vehicle, some of them changed."""
    return dataclasses.replace(load_vehicle(os.path.join(FOLDER, name + ".yaml")), **changes)


TESLA = preset()
