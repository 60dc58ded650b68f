"""Sonars: a vehicle's multibeams and imaging sonars, and soundings along bent rays."""
