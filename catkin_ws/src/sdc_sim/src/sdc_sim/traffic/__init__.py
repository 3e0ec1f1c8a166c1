"""What moves and shines on a map: the other road users, which SUMO moves, and the lights."""
