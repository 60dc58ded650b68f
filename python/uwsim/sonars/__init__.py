"""Sonars: the multibeam of a vehicle, imaging sonars, soundings through bent rays."""
