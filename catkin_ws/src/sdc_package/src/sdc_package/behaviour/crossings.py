"""The old name of `sdc_map.crossings`, for students' workspaces."""

import sys

from sdc_map import crossings

sys.modules[__name__] = crossings
