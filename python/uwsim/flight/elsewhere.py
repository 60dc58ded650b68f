"""Flights that are flown elsewhere, by a program outside: the socket `uwsim.flights`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from uwsim.base.options import Options
from uwsim.base.registered_options import RegisteredOptions

if TYPE_CHECKING:
    from uwsim.flight.record import FlightRecord


class OtherFlight(Options):
    """The base of the options of a flight that is flown elsewhere. Its switch requests it."""

    def fly(self, mission: Path, out: Path, **options: Any) -> FlightRecord:
        """Fly a mission's file, and return its record. options: those of `uwsim.fly` that are given, and `truth`."""
        raise NotImplementedError


class Elsewhere(RegisteredOptions[OtherFlight]):
    """The options of all that fly elsewhere; at most one is requested."""

    socket = "uwsim.flights"
    base = OtherFlight
