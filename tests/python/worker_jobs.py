"""Jobs for worker tests, in a separate module because each worker imports it."""

import os
import signal
import time
from pathlib import Path


def double(job: int) -> dict:
    """Return twice the job's value."""
    return {"value": 2 * job}


def die_at_three(job: int) -> dict:
    """Kill the worker process on job 3."""
    if job == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"value": job}


def fail_at_first(job: str) -> dict:
    """Raise an OSError on the first call only, like a disk error that does not recur."""
    path = Path(job)
    if not path.exists():
        path.touch()
        raise OSError("not yet")
    return {"value": 1}


def tell_and_take_long(job: tuple[int, str]) -> dict[str, object]:
    """On the first call, write this process's PID to a file and wait to be interrupted."""
    number, told = job
    if number == 0 and not Path(told).exists():
        Path(told).write_text(str(os.getpid()))
        time.sleep(2.0)
    return {"value": number}
