"""What a worker process does first: it leaves Ctrl-C, which a terminal sends to all processes, to the first."""

from __future__ import annotations

import signal


def dask_setup(worker: object) -> None:
    """Dask calls this when a worker starts."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
