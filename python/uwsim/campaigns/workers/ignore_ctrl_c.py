"""Worker process set-up: workers ignore Ctrl-C, which terminals send to all processes, and leave it to the parent."""

from __future__ import annotations

import signal


def dask_setup(worker: object) -> None:
    """Ignore Ctrl-C; Dask calls this when a worker starts."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
