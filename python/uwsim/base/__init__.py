"""Code that all packages share and that needs no simulator: value checks, files, locks, signals, the agenda."""
