"""Observing a simulation does not change it: the true world has the same bytes with observers and without."""

import random
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import pytest

from uwsim import Simulator
from uwsim.base.agenda import NEVER, Rank
from uwsim.bridges.imc.readings import Instruments, Place
from uwsim.bridges.mavlink import state
from uwsim.bridges.moos import variables
from uwsim.bridges.nmea import readings as nmea
from uwsim.channels import Table
from uwsim.channels.delivery.feed import Feed
from uwsim.channels.families.estimate import has_estimate
from uwsim.live import LiveSimulator
from uwsim.recording import Recorder
from uwsim.recording.filming.roll import Roll
from uwsim.recording.replay import replay
from uwsim.scenario.georeference import georeference
from uwsim.scenario.load import packaged_scenarios

SMALL = ("pool", "lagoon", "lake_boat")
FLOWN_S, SAMPLE_S = 4.0, 0.25
Observe = Callable[[Simulator, ExitStack], Callable[[int], object]]


class At:
    """An item of the agenda that acts at given ticks."""

    def __init__(self, sim: Simulator, rank: Rank, ticks: list[int], act: Callable[[], object]) -> None:
        self._ticks = sorted(ticks, reverse=True)
        sim.agenda.add(self, rank, lambda tick: (self._ticks.pop(), act()))

    @property
    def due_tick(self) -> int:
        return self._ticks[-1] if self._ticks else NEVER


def piloted(sim: Simulator) -> Iterator[None]:
    """Command each vehicle at each `next`: it is driven, holds what it can, is driven, and holds again."""
    for surge in (0.6, 0.0, -0.4, 0.0):
        for hull in sim.vehicles.values():
            if not hull.released:
                hull.undock()
            hull.set_effort(surge=surge, yaw=0.3 * surge)
            able = hull.holds.possible if hull.holds is not None and not surge else []
            if wanted := {name: True for name in ("heading", "depth", "position") if name in able}:
                hull.command("hold", **wanted)
        yield


def flown(name: str, observe: Observe = lambda sim, stack: sim.step) -> list[bytes]:
    """Fly for FLOWN_S; return the complete state of the native simulation every SAMPLE_S."""
    sim, truth = Simulator(name, threads=1), list[bytes]()
    steps, every, acts = round(FLOWN_S / sim.step_s), round(SAMPLE_S / sim.step_s), piloted(sim)
    At(sim, Rank.REPLAY, [1 + k * steps // 4 for k in range(4)], lambda: next(acts))
    At(sim, Rank.REPLAY, list(range(every, steps + 1, every)), lambda: truth.append(sim._core.save_state("", "", "")))
    with ExitStack() as stack:
        observe(sim, stack)(steps)
    return truth


def readings(sim: Simulator) -> list[Callable[[], object]]:
    """Return what recordings, pages, bridges and programs read, as functions."""
    table, place, clock = Table(sim), georeference(sim.scenario), lambda time_s: datetime.fromtimestamp(time_s, UTC)
    found: list[Callable[[], object]] = [
        partial(each.read, sim) for each in table.channels if each.read is not None and not each.delivery.late
    ]
    for source in table.sources:
        hull = source.of(sim)
        for sensor in hull.sensors.values():
            found += [sensor.sample, partial(sensor.read, noise=False), lambda sensor=sensor: sensor.stream().take()]
        found += [sonar.ping for sonar in hull.sonars.values()]
        found += [partial(variables.instruments, hull), hull.telemetry]
        if has_estimate(source):
            found += [
                lambda hull=hull: hull.estimate.covariance,
                partial(state.read, sim, source, truth=False),
                partial(variables.navigation, hull, place, from_truth=False),
                lambda hull=hull: nmea.read(hull, place, clock, sim.time_s),
            ]
        if has_estimate(source) and place.crs is not None:
            of_imc = Instruments(hull, Place.of(place), {}, lambda time_s: time_s)
            found.append(lambda of_imc=of_imc: list(of_imc.read(sim.time_s)))
    return found


def observed(sim: Simulator, stack: ExitStack, recording: Path) -> Callable[[int], object]:
    """Run live; record, film, read all channels but pictures, as servers and the page do, and the rest at random."""
    live = stack.enter_context(LiveSimulator(sim, speed="max", paused=True))
    stack.enter_context(Recorder(live, recording, is_light=True))
    Roll(0.0, FLOWN_S, 5.0, None, None).attach(sim)
    feed = Feed(live)
    for channel in Table(sim).channels:
        if channel.direction == "out" and not channel.delivery.late:
            stack.callback(feed.listen(channel, lambda reading: None))
    draws, of_it = random.Random(7), readings(sim)
    ticks = draws.sample(range(1, round(FLOWN_S / sim.step_s)), 60)
    At(sim, Rank.OBSERVER, ticks, lambda: [each() for each in draws.sample(of_it, min(8, len(of_it)))])
    for camera in [*sim.cameras.values(), *sim.rov.cameras.values()][:1]:
        At(sim, Rank.OBSERVER, ticks[:1], camera.capture)
    return live.step


def require_same(name: str, recording: Path) -> None:
    expected = flown(name)
    assert flown(name, partial(observed, recording=recording)) == expected
    assert replay(recording).difference is None


@pytest.mark.parametrize("name", SMALL)
def test_a_flight_is_the_same_with_observers_and_without(name: str, tmp_path: Path) -> None:
    require_same(name, tmp_path / "run.mcap")


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", [each for each in packaged_scenarios() if each not in SMALL])
def test_every_packaged_scenario_is_the_same_with_observers_and_without(name: str, tmp_path: Path) -> None:
    require_same(name, tmp_path / "run.mcap")
