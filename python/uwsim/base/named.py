"""Read-only collections of items by name, such as a vehicle's sensors, and hints about unknown names."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from typing import Any, NoReturn, TypeVar

MIN_SIMILARITY = 0.6  # difflib's ratio: from 0 (nothing in common) to 1 (equal)


def did_you_mean(name: str, known: Iterable[str], written: Mapping[str, str] | None = None) -> str:
    """Return `; did you mean 'sonar'?` if a known name is similar, else "".

    written: how a name is written where it is not a plain name, such as {"imu": "sensors['imu']"}.
    """
    spelt = {each.lower(): each for each in known}
    near = difflib.get_close_matches(name.lower(), spelt, n=1, cutoff=MIN_SIMILARITY)
    if not near:
        return ""
    found = spelt[near[0]]
    return f"; did you mean {(written or {}).get(found, repr(found))}?"


T = TypeVar("T")


class UnknownNameError(KeyError, ValueError):
    """Raised for an unknown name of a sensor, camera or vehicle. The message lists the known names."""

    def __str__(self) -> str:
        return str(self.args[0])  # KeyError would show its repr


class Named(dict[str, T]):
    """A read-only dict whose lookups of unknown names raise UnknownNameError.

    what: the name of the collection in messages, such as `rov.sensors`. changed_by: the method that error messages
    suggest in place of an assignment.
    """

    def __init__(self, items: Mapping[str, T], what: str, changed_by: str = "") -> None:
        super().__init__(items)
        self._what = what
        self._changed_by = changed_by

    def __missing__(self, name: object) -> NoReturn:
        rule = f"must be one of {', '.join(self)}" if self else "there are none"
        raise UnknownNameError(f"{self._what}[{name!r}]: {rule}{did_you_mean(str(name), self)}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (dict(self), self._what, self._changed_by)

    def _refuse(self, *_: object, **__: object) -> NoReturn:
        raise TypeError(f"{self._what}: read-only" + (f"; use {self._changed_by}" if self._changed_by else ""))

    __setitem__ = __delitem__ = __ior__ = _refuse
    update = pop = popitem = clear = setdefault = _refuse


def require_names(what: str, names: Iterable[str], known: Iterable[str]) -> None:
    """Raise ValueError unless `names` and `known` contain the same names, in any order."""
    given, expected = sorted(names), sorted(known)
    if given != expected:
        rule = f"must have {', '.join(expected) or 'none'}"
        raise ValueError(f"state.{what}: has {', '.join(given) or 'none':.200}: {rule}")
