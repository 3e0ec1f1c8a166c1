"""Record drives, train a network, and let it drive; see docs/labs/imitation.md."""
