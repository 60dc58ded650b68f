"""Sweeps: one survey or mission flown many times, with other figures each time, on many processes."""

from uwsim.campaigns.sweeps.sweep import Sweep, fly_again, run_sweep

__all__ = ["Sweep", "fly_again", "run_sweep"]
