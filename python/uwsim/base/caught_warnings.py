"""warnings.catch_warnings for code that several threads run."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from threading import RLock

_ONE_THREAD = RLock()


@contextmanager
def caught_warnings() -> Iterator[list[warnings.WarningMessage]]:
    """Collect the warnings issued in the block, by one thread at a time.

    The filters and the hook are global to the process and are restored at the end of a block: if two blocks overlapped,
    those of the first would remain in place, and the process would no longer show warnings.
    """
    with _ONE_THREAD, warnings.catch_warnings(record=True) as issued:
        warnings.simplefilter("always")
        yield issued
