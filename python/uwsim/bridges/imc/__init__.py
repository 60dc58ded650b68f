"""The simulator as a vehicle's hardware for DUNE, and as a vehicle for Neptus."""
