#!/usr/bin/env python3
"""Drive all cells of a study: rosrun sdc_experiments sweep.py STUDY.yaml [--scheduler ADDRESS]."""

from sdc_experiments.sweep.command import main

if __name__ == "__main__":
    main()
