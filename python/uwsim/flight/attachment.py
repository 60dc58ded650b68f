"""Attachments: what takes part in a flight from another room, such as a recorder, and flights that are flown elsewhere.

Attachments are registered by entry points in the group `uwsim.attachments`. An entry is a class of options:

    @dataclass(frozen=True)
    class Diary(AttachmentOptions):
        switch = "diary"  # without it, it attaches to every flight

        diary: Path | None = option(None, "Write a diary into this file.", metavar="FILE", is_written=True)

        def attach(self, flight: Departure) -> Attachment | None:
            return DiaryOf(flight, self.diary)

Then `uwsim run` and `uwsim survey` have the flag `--diary FILE`, and `uwsim.fly` the keyword `diary`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uwsim.base.journal import Observer
from uwsim.base.options import Options, RegisteredOptions

if TYPE_CHECKING:
    from uwsim.base.wall_timer import WallTimer
    from uwsim.flight.pinging import TakePing
    from uwsim.flight.record import FlightRecord
    from uwsim.flight.request import FlightRequest
    from uwsim.simulator.simulator import Simulator


@dataclass(frozen=True)
class Departure:
    """A flight that is about to begin, as its attachments see it.

    names: the vehicles that fly. is_planned: whether they fly the scenario's survey. has_map: whether pings are mapped.
    request: what was asked for, for the flight's own files, if it writes any. carried: name endings of the channels
    that cross a link. others: those attached earlier, by name.
    """

    sim: Simulator
    names: tuple[str, ...]
    is_planned: bool
    has_map: bool
    request: FlightRequest | None = None
    carried: tuple[str, ...] | None = None
    others: dict[str, Attachment] = field(default_factory=dict)


class Attachment:
    """Takes part in one flight, in the order of these methods. It is made before anything is written.

    on_ping: called with each mapped ping. table: the simulator's channels, if it uses them, for attachments after it.
    timer: the flight's stages, set before `start`.
    """

    on_ping: TakePing | None = None
    table: Any = None
    timer: WallTimer | None = None

    def start(self) -> None:
        """Begin, before the mission does; files may be created. Raises OSError."""

    @contextmanager
    def flying(self) -> Iterator[None]:
        """Take part while the mission is flown."""
        yield

    @property
    def observer(self) -> Observer | None:
        """An observer of the simulator that is called after the pings of its tick."""
        return None

    def ended(self, flown: FlightRecord) -> FlightRecord:
        """Return the flight's record, with what this attachment adds to it."""
        return flown

    def try_close(self) -> OSError | None:
        """Close files, however the flight ended; return the error if writing failed."""
        return None


class AttachmentOptions(Options):
    """The base of an attachment's options."""

    def attach(self, flight: Departure) -> Attachment | None:
        """Return what takes part in a flight, or None if there is nothing to do. Raises ValueError or OSError."""
        raise NotImplementedError


class Attachments(RegisteredOptions[AttachmentOptions]):
    """The options of all attachments that are registered."""

    socket = "uwsim.attachments"
    base = AttachmentOptions
    is_switched = False

    @property
    def arguments(self) -> dict[str, Any]:
        """The options that are given, as keywords of `uwsim.fly`."""
        return {name: value for each in self.requested.values() for name, value in each.arguments.items()}


class OtherFlight(Options):
    """The base of the options of a flight that is flown elsewhere. Its switch requests it."""

    def fly(self, mission: Path, out: Path, **options: Any) -> FlightRecord:
        """Fly a mission's file, and return its record. options: those of `uwsim.fly` that are given, and `truth`."""
        raise NotImplementedError


class Elsewhere(RegisteredOptions[OtherFlight]):
    """The options of all that fly elsewhere; at most one is requested."""

    socket = "uwsim.flights"
    base = OtherFlight
