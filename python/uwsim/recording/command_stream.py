"""Merges the commands by which one argument, such as a head's tilt, takes many values into a single event."""

from __future__ import annotations

from typing import NamedTuple

from uwsim.base.texts.value_words import Detail, details, with_details, words
from uwsim.recording.commands import Command

ADDS = frozenset({"inject_fault", "note", "link_send"})
"""Commands of which each adds something, also the second of two equal ones."""


class CommandStream(NamedTuple):
    """Equal commands, except that one argument, a number, only grows or only falls, as when a head is turned.

    They are one event, since the first and the last value then describe all of them. key: that argument, or "" before
    its value has changed.
    """

    first: Command
    last: Command
    key: str = ""

    def with_next(self, command: Command) -> CommandStream | None:
        """Return the stream with another command, or None if that is an event of its own, such as any switch."""
        old, new = self.last.arguments, command.arguments
        if command.name != self.last.name or command.name in ADDS or old.keys() != new.keys():
            return None
        changed = [key for key in new if new[key] != old[key]]
        if not changed:
            may_repeat = any(map(_is_number, new.values())) and not any(isinstance(v, bool) for v in new.values())
            return self._replace(last=command) if may_repeat else None
        (key, *others) = changed
        if others or self.key not in ("", key) or not (_is_number(old[key]) and _is_number(new[key])):
            return None
        if self.key and (new[key] > old[key]) != (old[key] > self.first.arguments[key]):
            return None  # there and back is two events
        return self._replace(last=command, key=key)

    @property
    def text(self) -> str:
        """The command with its vehicle and details."""
        return with_details(f"{words(self.last.name)} {self.vehicle}".strip(), self.details)

    @property
    def vehicle(self) -> str:
        """The vehicle that it commands, or ""."""
        return str(self.last.arguments.get("vehicle") or "")

    @property
    def details(self) -> list[Detail]:
        """The arguments in words: of the one that changes, the first and the last value."""
        given = {key: value for key, value in self.first.arguments.items() if key != "vehicle"}
        return details(given, self.last.arguments)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
