"""Sweeps: one survey or mission flown many times with different values, in parallel processes."""

from uwsim.campaigns.sweeps.plan import SweepPlan, plan_sweep
from uwsim.campaigns.sweeps.sweep import Sweep, fly_again, run_sweep

__all__ = ["Sweep", "SweepPlan", "fly_again", "plan_sweep", "run_sweep"]
