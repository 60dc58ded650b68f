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

    The filters and the hook belong to the whole process and are restored at the end of a block: two blocks that overlap
    would leave those of the first in place, and the process without warnings.
    """
    with _ONE_THREAD, warnings.catch_warnings(record=True) as issued:
        warnings.simplefilter("always")
        yield issued
