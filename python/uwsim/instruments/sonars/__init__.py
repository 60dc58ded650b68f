"""Sonars: a vehicle's multibeam, imaging sonars, and soundings along bent rays."""
