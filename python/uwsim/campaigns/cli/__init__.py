"""Commands for sweeps, fleets and datasets."""
