"""Settings for all tests: Hypothesis tries the same examples on every run, and figures open no window."""

import os

from hypothesis import settings

os.environ.setdefault("MPLBACKEND", "Agg")
settings.register_profile("uwsim", derandomize=True, deadline=None, database=None)
settings.load_profile("uwsim")
