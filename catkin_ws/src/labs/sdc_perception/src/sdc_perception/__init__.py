"""Lane detection in the camera picture, and driving by it."""
