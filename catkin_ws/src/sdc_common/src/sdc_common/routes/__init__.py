"""Routes as files of waypoints."""
