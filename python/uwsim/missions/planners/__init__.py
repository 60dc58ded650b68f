"""Planners: missions that decide where to fly from what the vehicle sees. One idea per file; each is a step."""
