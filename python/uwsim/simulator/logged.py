"""Logged: values of a user's own, which recordings and servers offer as topics; see Simulator.log."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any
from weakref import WeakSet

from uwsim.base.arguments import Value, checked_value


class Logged:
    """The topics that a user has logged. values: the latest, by topic. offered: what offers the topics there are."""

    def __init__(self) -> None:
        self.values: dict[str, Value] = {}
        self.offered: WeakSet[Any] = WeakSet()
        self._takers: dict[str, tuple[Callable[[Value], object], ...]] = {}

    def log(self, topic: str, values: Mapping[str, Any]) -> None:
        """Take values; see Simulator.log. Raises ValueError, changing nothing."""
        if not isinstance(values, Mapping) or not values:
            raise ValueError(f"log '{topic!s:.80}': values = {values!r:.60}: must be a dict of values by name")
        names = {f"{topic}/{key}".removeprefix("/"): each for key, each in values.items()}
        found = {name: checked_value(f"/{name}", each) for name, each in names.items()}
        for name, value in found.items():
            if name not in self.values and self.offered:
                raise ValueError(f"log '/{name}': is new, and a recorder or server is open: log it before it opens")
            if type(before := self.values.get(name, value)) is not type(value):
                raise ValueError(f"log '/{name}' = {value!r:.60}: must be a {type(before).__name__}, as before")
        self.values |= found
        for name, value in found.items():
            for take in self._takers.get(name, ()):
                take(value)

    def listen(self, name: str, take: Callable[[Value], object]) -> Callable[[], None]:
        """Call a function with each value of a topic from now on; return what ends that."""
        self._takers[name] = (*self._takers.get(name, ()), take)

        def end() -> None:
            self._takers[name] = tuple(each for each in self._takers[name] if each is not take)

        return end
