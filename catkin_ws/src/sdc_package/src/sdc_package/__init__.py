"""The library of the self-driving car: what its nodes compute."""
