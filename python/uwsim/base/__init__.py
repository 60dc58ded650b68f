"""Shared by all rooms, without knowledge of a simulator: checks of values, files, locks, signals, the agenda."""
