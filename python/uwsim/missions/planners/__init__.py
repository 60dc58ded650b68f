"""Planners: missions that decide where to fly from what the vehicle senses. Each method is a step in its own file."""
