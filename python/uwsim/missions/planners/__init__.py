"""Planners: missions that decide where to fly from what the vehicle sees. One idea a file; each is a step."""
