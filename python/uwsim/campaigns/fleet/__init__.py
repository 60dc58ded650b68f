"""Fleets: a large area in tiles, each surveyed by its own vehicle, with all maps merged into one."""

from uwsim.campaigns.fleet.fleet import Fleet, run_fleet

__all__ = ["Fleet", "run_fleet"]
