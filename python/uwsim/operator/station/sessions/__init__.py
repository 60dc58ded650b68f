"""Simulators that the station runs, one at a time, and what goes on in one: exercises, notes, saves."""
