"""An operator's notes in a run's log of events: part of its state, like the others."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from uwsim.base.agenda import Agenda
from uwsim.commands import COMMENT, NOTE, NOTES_MAX, require_note
from uwsim.simulator.failures.events import Event, EventLog


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
    """Log a note. position_world_m: (3,), of what it is about, None if unknown.

    Raises ValueError, also if there are NOTES_MAX.
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
    """Return the comment that stands in pictures now, "" for none."""
    comments = [event.values["text"] for event in notes_of(events) if event.values["category"] == COMMENT]
    return comments[-1] if comments else ""
