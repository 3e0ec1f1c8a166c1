"""Figures and experiments of the lab."""
