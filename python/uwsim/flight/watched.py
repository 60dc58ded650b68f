"""Attaches the observers of a flight: sampling and mapping, and those of its attachments."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from uwsim.base.wall_timer import WallTimer
from uwsim.flight.pinging import MapMaker
from uwsim.flight.samples import OnEvent, Sampler
from uwsim.flight.setup import Setup
from uwsim.flight.stages import SAMPLING
from uwsim.missions.own_vehicle import OwnVehicle


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
