"""The jobs that tests give to workers: in a separate module, since each worker imports it."""

import os
import signal
import time
from pathlib import Path


def double(job: int) -> dict:
    """Return a value."""
    return {"value": 2 * job}


def die_at_three(job: int) -> dict:
    """Kill the worker, for one job."""
    if job == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"value": job}


def fail_at_first(job: str) -> dict:
    """Fail as a disk may, once."""
    path = Path(job)
    if not path.exists():
        path.touch()
        raise OSError("not yet")
    return {"value": 1}


def tell_and_take_long(job: tuple[int, str]) -> dict[str, object]:
    """Write this process's number into a file, the first time, and wait to be disturbed."""
    number, told = job
    if number == 0 and not Path(told).exists():
        Path(told).write_text(str(os.getpid()))
        time.sleep(2.0)
    return {"value": number}
