"""Speed planning along a route."""
