"""The road in the plane: lanes, lines, scenery, lane invasion and generated routes."""
