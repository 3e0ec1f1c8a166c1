"""Examines a student's workspace, step by step: what is right, what is wrong and why, and what nobody has written yet."""
