"""The old name of `sdc_map.lane_graph`, for students' workspaces."""

import sys

from sdc_map import lane_graph

sys.modules[__name__] = lane_graph
