"""Planners: missions that decide where to fly from what the vehicle senses. One method per file; each is a step."""
