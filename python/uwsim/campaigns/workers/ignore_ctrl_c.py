"""Setup of a worker process: it ignores Ctrl-C, which terminals send to all processes; the parent handles it."""

from __future__ import annotations

import signal


def dask_setup(worker: object) -> None:
    """Ignore Ctrl-C; Dask calls this when a worker starts."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
