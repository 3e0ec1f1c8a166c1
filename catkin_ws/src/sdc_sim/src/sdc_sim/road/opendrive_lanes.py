"""The old name of `sdc_map.opendrive_lanes`, for students' workspaces."""

import sys

from sdc_map import opendrive_lanes

sys.modules[__name__] = opendrive_lanes
