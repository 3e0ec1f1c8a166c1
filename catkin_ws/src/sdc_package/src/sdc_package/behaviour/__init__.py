"""What the car decides on streets: where it stops, and for whom."""
