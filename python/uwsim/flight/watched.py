"""Attaches the observers of a flight: sampling, mapping, and the station's end of the link."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from uwsim.base.wall_timer import WallTimer
from uwsim.flight.pinging import MapMaker
from uwsim.flight.samples import Hear, Sampler
from uwsim.flight.setup import Setup
from uwsim.flight.stages import SAMPLING
from uwsim.flight.vehicle_chain import ping_steps
from uwsim.missions.own_vehicle import OwnVehicle

if TYPE_CHECKING:
    from uwsim.flight.ashore import Ashore


@dataclass(frozen=True)
class Watched:
    """A flight that is about to begin or continue. own: its vehicles, as seen by the mission."""

    setup: Setup
    own: Mapping[str, OwnVehicle]
    timer: WallTimer
    begun_tick: int


@contextmanager
def sampling(flight: Watched, hear: Hear) -> Iterator[Sampler]:
    """Take samples while the block runs."""
    sim, saved = flight.setup.sim, flight.setup.saved
    rows = saved.samples if saved is not None and saved.mission is not None else None
    timer = flight.timer.measure(SAMPLING)
    with_sensors = flight.setup.sample_sensors
    sampler = Sampler(sim, flight.own, hear, timer, with_sensors=with_sensors, begun_tick=flight.begun_tick, saved=rows)
    sim.journal.attach(sampler, efforts=False)
    try:
        yield sampler
    finally:
        sim.journal.detach(sampler)


@contextmanager
def linked(flight: Watched) -> Iterator[Ashore | None]:
    """Carry vehicle messages to the station while the block runs, if the scenario has a link."""
    setup, sim = flight.setup, flight.setup.sim
    if sim.link is None:
        yield None
        return
    from uwsim.channels import Table  # here, since channels are slow to import

    recorded = None if setup.recorder is None else setup.recorder.table
    table = recorded or Table(sim)  # shared by recorder and link
    if setup.mapping is None:
        from uwsim.link import Carrier

        with Carrier(sim, table):
            yield None
        return
    from uwsim.flight.ashore import Ashore

    name, saved = setup.names[0], None
    if setup.saved is not None and setup.saved.mission is not None:
        saved = setup.saved.mission.ashore
    ashore = Ashore(sim, table, name, ping_steps(sim, name), only=setup.carried, saved=saved)
    try:
        yield ashore
    finally:
        ashore.close()


@contextmanager
def mapping(flight: Watched, ashore: Ashore | None) -> Iterator[MapMaker | None]:
    """Build the map while the block runs, and collect the pings that arrive ashore."""
    setup, journal = flight.setup, flight.setup.sim.journal
    if setup.mapping is None:
        yield None
        return
    saved = None if setup.saved is None else setup.saved.pinging
    with MapMaker(
        setup.sim, flight.own, setup.mapping, flight.timer, begun_tick=flight.begun_tick, saved=saved
    ) as maker:
        if ashore is not None:
            journal.attach(ashore)  # after the pings of its tick
        try:
            yield maker
        finally:
            if ashore is not None:
                journal.detach(ashore)
