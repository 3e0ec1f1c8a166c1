"""The old name of `sdc_map.network_file`, for students' workspaces."""

import sys

from sdc_map import network_file

sys.modules[__name__] = network_file

if __name__ == "__main__":
    network_file.main()
