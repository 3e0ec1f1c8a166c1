"""Checks of the steps: each runs a student's code in the student's own environment."""
