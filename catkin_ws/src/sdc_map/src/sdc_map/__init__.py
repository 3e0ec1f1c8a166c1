"""Maps of streets: their lanes and junctions, and the way over them."""
