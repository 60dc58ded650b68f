"""Writes scenarios for other simulators."""
