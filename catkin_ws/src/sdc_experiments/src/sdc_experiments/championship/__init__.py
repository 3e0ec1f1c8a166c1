"""The championship: drivers of anyone on roads that a seed draws; see docs/championship.md."""
