"""Sonars: a vehicle's multibeams, imaging sonars, and soundings along bent rays."""
