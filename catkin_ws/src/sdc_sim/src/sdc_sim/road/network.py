"""The old name of `sdc_map.network`, for students' workspaces."""

import sys

from sdc_map import network

sys.modules[__name__] = network
