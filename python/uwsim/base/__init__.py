"""Code shared by all packages and independent of the simulator: value checks, files, locks, signals, the agenda."""
