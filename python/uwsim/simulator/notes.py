"""An operator's notes in a run's event log: part of the run's state, like all other events."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from uwsim.base.agenda import Agenda
from uwsim.base.commands import COMMENT, NOTE, NOTES_MAX, require_note
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
