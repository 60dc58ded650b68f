"""Shared by all rooms, without dependence on a simulator: checks of values, files, locks, signals, the agenda."""
