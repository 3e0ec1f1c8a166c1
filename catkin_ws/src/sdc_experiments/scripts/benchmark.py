#!/usr/bin/env python3
"""Measure what this project costs: rosrun sdc_experiments benchmark.py [NAME ...] [--rounds N]."""

from sdc_experiments.benchmarks.command import main

if __name__ == "__main__":
    main()
