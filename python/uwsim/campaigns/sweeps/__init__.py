"""Sweeps: one survey or mission flown many times with different values, in parallel processes."""

from uwsim.campaigns.sweeps.sweep import Sweep, fly_again, run_sweep

__all__ = ["Sweep", "fly_again", "run_sweep"]
