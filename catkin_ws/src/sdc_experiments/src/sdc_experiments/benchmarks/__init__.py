"""What `rosrun sdc_experiments benchmark.py` measures.

A benchmark is a generator: it prepares itself, and then yields rounds. A round measures some things
in turns, because other programs change the speed of a machine from minute to minute, and is a dict
of their names and values.
"""
