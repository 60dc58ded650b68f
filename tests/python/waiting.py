"""Waiting, in tests, for something that another thread or process does."""

import time
from collections.abc import Callable
from typing import Any


def until(condition: Callable[[], Any], what: str = "it", limit_s: float = 180.0) -> Any:
    """Wait until a condition is true and return its value. The limit is generous because the machine may be busy."""
    end_s = time.monotonic() + limit_s
    while not (value := condition()):
        assert time.monotonic() < end_s, f"{what} did not happen in {limit_s:g} s"
        time.sleep(0.005)
    return value
