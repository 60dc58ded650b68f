"""Many flights or frames in parallel processes: sweeps, fleets, datasets, and the workers they share."""
