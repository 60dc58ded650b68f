"""Fleets: a large area in tiles, each surveyed by a vehicle of its own, and the maps of all as one."""

from uwsim.campaigns.fleet.fleet import Fleet, run_fleet

__all__ = ["Fleet", "run_fleet"]
