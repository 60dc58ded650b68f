"""What happened by itself in a run: faults, alarms, failsafes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, overload


@dataclass(frozen=True)
class Event:
    """Something that happened at a tick. vehicle: "" for the world. values: of JSON's types."""

    tick: int
    time_s: float
    vehicle: str
    name: str
    values: dict[str, Any] = field(default_factory=dict)


class EventLog(Sequence[Event]):
    """The events of a run, in order."""

    def __init__(self, step_s: float) -> None:
        self._step_s = step_s
        self._events: list[Event] = []

    def add(self, tick: int, vehicle: str, name: str, **values: Any) -> None:
        """Note an event."""
        self._events.append(Event(tick, round(tick * self._step_s, 9), vehicle, name, values))

    @overload
    def __getitem__(self, index: int) -> Event: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Event]: ...
    def __getitem__(self, index: int | slice) -> Event | Sequence[Event]:
        """Return an event, or several."""
        return self._events[index]

    def __len__(self) -> int:
        return len(self._events)

    def __repr__(self) -> str:
        last = f", the last: {self._events[-1].name} at {self._events[-1].time_s:g} s" if self._events else ""
        return f"<EventLog: {len(self._events)} events{last}>"

    def __iter__(self) -> Iterator[Event]:
        return iter(self._events)

    def save(self) -> list[dict[str, Any]]:
        """Return the events as JSON values."""
        return [asdict(event) for event in self._events]

    def restore(self, events: Sequence[dict[str, Any]]) -> None:
        """Hold what `save` returned."""
        self._events = [Event(**event) for event in events]
