#!/usr/bin/env python3
"""Watch every process for hours: rosrun sdc_experiments soak.py [hours:=10] [camera:=false]."""

from sdc_experiments.soak import main

if __name__ == "__main__":
    main()
