"""The events of a run: faults, alarms, failsafe reactions, and an operator's notes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, ClassVar, overload

from pydantic import FiniteFloat

from uwsim.base.agenda import Agenda
from uwsim.base.commands import COMMENT, NOTE, NOTES_MAX, require_note
from uwsim.base.saved_state import State, Tick
from uwsim.base.texts.value_words import Detail, details, words


@dataclass(frozen=True)
class Event:
    """An event at a tick. vehicle: name of the vehicle, or "" for the world. values: details, of JSON types."""

    tick: int
    time_s: float
    vehicle: str
    name: str
    values: dict[str, Any] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """The event in words, such as `fault thruster, thruster front_left`: texts without their names."""
        values = ", ".join(each.text if isinstance(value, str) else str(each) for each, value in self._said())
        return " ".join(filter(None, (words(self.name), values)))

    @property
    def details(self) -> list[Detail]:
        """The values in words."""
        return [each for each, _ in self._said()]

    def _said(self) -> Iterator[tuple[Detail, Any]]:
        for key, value in self.values.items():
            for each in details({key: value}):
                yield each, value


class EventState(State):
    """A saved event."""

    tick: Tick
    time_s: FiniteFloat
    vehicle: str
    name: str
    values: dict[str, Any]


class EventLog(Sequence[Event]):
    """The events of a run in chronological order."""

    STATE: ClassVar[Any] = list[EventState]

    def __init__(self, step_s: float) -> None:
        self._step_s = step_s
        self._events: list[Event] = []

    def add(self, tick: int, vehicle: str, name: str, **values: Any) -> None:
        """Add an event. Tuples become lists, which they are after `restore`."""
        values = {key: list(value) if isinstance(value, tuple) else value for key, value in values.items()}
        self._events.append(Event(tick, round(tick * self._step_s, 9), vehicle, name, values))

    @overload
    def __getitem__(self, index: int) -> Event: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Event]: ...
    def __getitem__(self, index: int | slice) -> Event | Sequence[Event]:
        """Return one event or several."""
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

    def restore(self, state: Sequence[EventState]) -> None:
        """Load events returned by `save`, replacing the current ones."""
        self._events = [Event(**dict(event)) for event in state]


def write_note(
    events: EventLog,
    agenda: Agenda,
    vehicle: str,
    *,
    text: str,
    category: str = "observation",
    position_world_m: Sequence[float] | None = None,
    picture: str = "",
) -> None:
    """Log a note. position_world_m: (3,), the position of the note's subject; None if unknown.

    Raises ValueError for invalid arguments, or if there are already NOTES_MAX notes.
    """
    require_note(text, category, picture)
    if len(notes_of(events)) >= NOTES_MAX:
        raise ValueError(f"command 'note': there are {NOTES_MAX} notes already")
    place = None if position_world_m is None else [float(value) for value in position_world_m]
    events.add(agenda.tick, vehicle, NOTE, text=text, category=category, position_world_m=place, picture=picture)


def notes_of(events: Iterable[Event]) -> list[Event]:
    """Return the notes among events, comments included."""
    return [event for event in tuple(events) if event.name == NOTE]


def comment_of(events: Iterable[Event]) -> str:
    """Return the comment currently shown in pictures; "" if there is none."""
    comments = [event.values["text"] for event in notes_of(events) if event.values["category"] == COMMENT]
    return comments[-1] if comments else ""
