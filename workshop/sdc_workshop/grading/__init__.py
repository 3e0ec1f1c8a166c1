"""Grading: the checks of many workspaces, and their summary."""
