"""Fleets: a large area divided into tiles, each surveyed by a separate vehicle, with all maps merged into one."""

from uwsim.campaigns.fleet.fleet import Fleet, run_fleet

__all__ = ["Fleet", "run_fleet"]
