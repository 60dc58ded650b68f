"""Settings that all tests share: the same examples on every run, and no window for a picture."""

import os

from hypothesis import settings

os.environ.setdefault("MPLBACKEND", "Agg")
settings.register_profile("uwsim", derandomize=True, deadline=None, database=None)
settings.load_profile("uwsim")
