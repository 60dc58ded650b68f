"""A variant of warnings.catch_warnings for code that runs in several threads."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from threading import RLock

_ONE_THREAD = RLock()


@contextmanager
def caught_warnings() -> Iterator[list[warnings.WarningMessage]]:
    """Collect the warnings issued in the block, which only one thread may enter at a time.

    The filters and the hook are global to the process, and each block restores those that it found. If two blocks
    overlapped, the filters of the first would stay in place, and the process would no longer show warnings.
    """
    with _ONE_THREAD, warnings.catch_warnings(record=True) as issued:
        warnings.simplefilter("always")
        yield issued
