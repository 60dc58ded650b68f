"""The validated setup of a flight, ready for the engine."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from uwsim.flight.autosave import FlightAutosave
from uwsim.flight.missions import FlownMission
from uwsim.flight.pinging import MapSetup
from uwsim.flight.request import EstimateKind, FlightRequest
from uwsim.flight.saved_flight import SavedFlight
from uwsim.flight.terminal import Silent
from uwsim.missions import LawnMowerPlan
from uwsim.simulator.simulator import Simulator

if TYPE_CHECKING:
    from uwsim.flight.flight_recorder import FlightRecorder


@dataclass
class Setup:
    """The parts of a flight, already validated; see fly() for their meaning.

    request: None for a flight that cannot be saved. mapping: None without a map. plan, lanes_left_out: see
    FlownMission.planned. saved: the flight to resume. sample_sensors: whether `samples` include the sensors' readings.
    """

    sim: Simulator
    mission: FlownMission
    names: tuple[str, ...]
    estimate: EstimateKind = "truth"
    mapping: MapSetup | None = None
    close_loops: bool = False
    time_limit_s: float | None = None
    plan: LawnMowerPlan | None = None
    lanes_left_out: str | None = None
    carried: tuple[str, ...] | None = None
    recorder: FlightRecorder | None = None
    out: Path | None = None
    request: FlightRequest | None = None
    sample_sensors: bool = True
    report: str = "full"
    autosave: FlightAutosave | None = None
    screen: Silent = Silent()  # noqa: RUF009  # Silent has no state
    saved: SavedFlight | None = None
