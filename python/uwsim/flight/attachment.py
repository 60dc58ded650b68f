"""Attachment: what takes part in a flight from another room, such as a recorder or the station's end of a link.

Attachments are registered by entry points in the group `uwsim.attachments`. An entry is a function that receives a
Departure and returns an Attachment, or None if it has nothing to do in this flight.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from uwsim.base.journal import Observer
    from uwsim.flight.patch_errors import PatchErrors
    from uwsim.flight.pinging import TakePing
    from uwsim.flight.record import FlightRecord
    from uwsim.flight.request import FlightRequest
    from uwsim.scoring.tpu import Uncertainties
    from uwsim.simulator.simulator import Simulator


@dataclass(frozen=True)
class Departure:
    """A flight that is about to begin or to continue, as its attachments see it.

    names: the vehicles that fly. is_planned: whether they fly the scenario's survey. has_map: whether pings are mapped.
    request: what was asked for, for the flight's own files, if it writes any. carried: name endings of the channels
    that cross a link. record, record_topics, raw, raw_errors, raw_known: see fly(). saved: the state of each attachment
    of the flight that continues, by name. others: those attached earlier, by name.
    """

    sim: Simulator
    names: tuple[str, ...]
    is_planned: bool
    has_map: bool
    request: FlightRequest | None = None
    carried: tuple[str, ...] | None = None
    record: Path | None = None
    record_topics: tuple[str, ...] | None = None
    raw: Path | None = None
    raw_errors: PatchErrors | None = None
    raw_known: Uncertainties | None = None
    saved: Mapping[str, Any] = field(default_factory=dict)
    others: dict[str, Attachment] = field(default_factory=dict)


class Attachment:
    """Takes part in one flight, in the order of these methods. It is made before anything is written.

    on_ping: called with each mapped ping. table: the simulator's channels, if it uses them, for attachments after it.
    """

    on_ping: TakePing | None = None
    table: Any = None

    def start(self) -> None:
        """Begin, before the mission does; files may be created. Raises OSError."""

    @contextmanager
    def flying(self) -> Iterator[None]:
        """Take part while the mission is flown."""
        yield

    @property
    def observer(self) -> Observer | None:
        """An observer of the simulator that is called after the pings of its tick, while a map is built."""
        return None

    def save(self) -> dict[str, Any] | None:
        """Return what a continued flight needs, as JSON values; None for nothing."""
        return None

    def ended(self, flown: FlightRecord) -> FlightRecord:
        """Return the flight's record, with what this attachment adds to it."""
        return flown

    def try_close(self) -> OSError | None:
        """Close files, however the flight ended; return the error if writing failed."""
        return None
