"""The validated setup of a flight, ready for the engine, and the observers that it attaches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from uwsim.base.wall_timer import WallTimer
from uwsim.flight.attachment import Attachment
from uwsim.flight.clock import FlightAutosave
from uwsim.flight.missions import FlownMission
from uwsim.flight.pinging import MapMaker, MapSetup
from uwsim.flight.record import SAMPLING
from uwsim.flight.request import EstimateKind
from uwsim.flight.samples import OnEvent, Sampler
from uwsim.flight.terminal import Silent
from uwsim.missions import LawnMowerPlan
from uwsim.missions.own_vehicle import OwnVehicle
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


@dataclass(frozen=True)
class Watched:
    """A flight that is about to begin. own: its vehicles, as seen by the mission."""

    setup: Setup
    own: Mapping[str, OwnVehicle]
    timer: WallTimer
    begun_tick: int


@contextmanager
def sampling(flight: Watched, on_event: OnEvent) -> Iterator[Sampler]:
    """Take samples while the block runs."""
    sim, timer = flight.setup.sim, flight.timer.measure(SAMPLING)
    sampler = Sampler(sim, flight.own, on_event, timer, with_sensors=flight.setup.sample_sensors)
    sim.journal.attach(sampler, efforts=False)
    try:
        yield sampler
    finally:
        sim.journal.detach(sampler)


@contextmanager
def mapping(flight: Watched) -> Iterator[MapMaker | None]:
    """Build the map, if there is one, while the block runs; attachments observe after the pings of a tick."""
    setup, journal, maker = flight.setup, flight.setup.sim.journal, None
    observers = [each.observer for each in setup.attachments.values()]
    with ExitStack() as stack:
        if setup.mapping is not None:
            maker = stack.enter_context(
                MapMaker(setup.sim, flight.own, setup.mapping, flight.timer, begun_tick=flight.begun_tick)
            )
        for observer in observers:
            if observer is not None:
                journal.attach(observer)
                stack.callback(journal.detach, observer)
        yield maker
