#!/usr/bin/env python3
"""Print what is in a map and what its file has otherwise; refuse one that cannot be used."""

import sys

from sdc_map.map_report import main

if __name__ == "__main__":
    sys.exit(main())
