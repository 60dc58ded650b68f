"""The validated setup of a flight, ready for the engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from uwsim.flight.attachment import Attachment
from uwsim.flight.autosave import FlightAutosave
from uwsim.flight.missions import FlownMission
from uwsim.flight.pinging import MapSetup
from uwsim.flight.request import EstimateKind
from uwsim.flight.terminal import Silent
from uwsim.missions import LawnMowerPlan
from uwsim.simulator.simulator import Simulator


@dataclass
class Setup:
    """The parts of a flight, already validated; see fly() for their meaning.

    mapping: None without a map. plan, lanes_left_out: see FlownMission.planned. sample_sensors: whether `samples`
    include the sensors' readings.
    """

    sim: Simulator
    mission: FlownMission
    names: tuple[str, ...]
    estimate: EstimateKind = "truth"
    mapping: MapSetup | None = None
    time_limit_s: float | None = None
    plan: LawnMowerPlan | None = None
    lanes_left_out: str | None = None
    attachments: Mapping[str, Attachment] = field(default_factory=dict)
    out: Path | None = None
    sample_sensors: bool = True
    report: str = "full"
    autosave: FlightAutosave | None = None
    screen: Silent = Silent()  # noqa: RUF009  # Silent has no state
