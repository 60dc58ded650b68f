"""Support for keys under the names of earlier versions: they are read, with a warning that gives the current name."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any

_OLD_FILE: ContextVar[bool] = ContextVar("old_file", default=False)


class OldNameWarning(UserWarning, FutureWarning):
    """Issued for a key or parameter under an earlier version's name, which a later version will reject."""


@dataclass(frozen=True)
class OnceNamed:
    """Annotation of a field: the name it had in an earlier version. factor: multiplies a value under that name.

    until: the version that no longer reads it.
    """

    name: str
    until: str
    factor: float = 1.0

    def todays(self, value: Any) -> Any:
        """Convert a value given under the old name. Anything but a number is left as it is, to be rejected later."""
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return value * self.factor if is_number and self.factor != 1.0 else value

    def value(self, todays: Any) -> Any:
        """Convert a current value back, the inverse of `todays`."""
        is_number = isinstance(todays, int | float) and not isinstance(todays, bool)
        return todays / self.factor if is_number and self.factor != 1.0 else todays


def warn_of_old_name(old: str, now: str, former: OnceNamed, *, stacklevel: int = 2) -> None:
    """Warn that `old` is now called `now`, unless within `of_an_earlier_version`."""
    if not is_of_an_earlier_version():
        scale = "" if former.factor == 1.0 else f", which is {former.factor:g} times the value"
        text = f"{old}: is now {now}{scale}; the old name is read until version {former.until}"
        warnings.warn(text, OldNameWarning, stacklevel=stacklevel + 1)


def renamed_argument(now: str, value: Any, former: OnceNamed, old_value: Any, *, stacklevel: int = 3) -> Any:
    """Return the value of a function's argument, which callers may still pass under its old name, with a warning.

    Raises ValueError if both are given.
    """
    if old_value is None:
        return value
    if value is not None:
        raise ValueError(f"{former.name}: is the old name of {now}: give one of them")
    warnings.warn(f"{former.name}: is now {now}", DeprecationWarning, stacklevel=stacklevel)
    return former.todays(old_value)


def is_of_an_earlier_version() -> bool:
    """Return whether the values being read are from a file that an earlier version of uwsim wrote."""
    return _OLD_FILE.get()


@contextmanager
def of_an_earlier_version() -> Iterator[None]:
    """Accept old names without a warning in this block, which reads a file written by an earlier version of uwsim."""
    token = _OLD_FILE.set(True)
    try:
        yield
    finally:
        _OLD_FILE.reset(token)
