"""Many flights or frames in parallel processes: sweeps, fleets, datasets, and their shared workers."""
