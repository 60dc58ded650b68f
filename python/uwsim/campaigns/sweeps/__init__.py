"""Sweeps: one survey or mission flown many times, each time with different values, on many processes."""

from uwsim.campaigns.sweeps.sweep import Sweep, fly_again, run_sweep

__all__ = ["Sweep", "fly_again", "run_sweep"]
