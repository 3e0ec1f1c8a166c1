"""Grades many students' workspaces side by side."""
