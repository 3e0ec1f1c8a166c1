"""Snider's comparison of steering methods, with this project's physics and methods.

Source: J. M. Snider, Automatic Steering Methods for Autonomous Automobile Path Tracking,
CMU-RI-TR-09-08, 2009.
"""
