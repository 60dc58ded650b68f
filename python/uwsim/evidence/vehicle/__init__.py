"""Reports on a vehicle: its derived properties, estimates of its coefficients, and trials in open water."""
