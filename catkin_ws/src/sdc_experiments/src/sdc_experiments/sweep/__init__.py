"""Sweeps: many drives over scenarios, parameters and seeds, distributed by Dask."""
