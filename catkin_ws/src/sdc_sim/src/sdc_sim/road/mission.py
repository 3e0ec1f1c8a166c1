"""The old name of `sdc_map.mission`, for students' workspaces."""

import sys

from sdc_map import mission

sys.modules[__name__] = mission
