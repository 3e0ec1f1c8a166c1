"""Geometry of paths in the plane: arc length, heading, curvature and the nearest place."""
