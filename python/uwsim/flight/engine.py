"""The flight engine: flies any mission in a simulator, with log, samples, map, link, recording and results."""

from __future__ import annotations

import math
import time
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uwsim.base.arrays import Floats
from uwsim.base.wall_timer import WallTimer
from uwsim.flight.clock import End, FlightAutosave, FlightClock, FlightOverError, run_to_end
from uwsim.flight.folder import remove_stale_results
from uwsim.flight.log import MissionLog
from uwsim.flight.missions import Begun, warn_of_left_out
from uwsim.flight.record import (
    AUTOSAVE,
    BATTERY_EMPTY,
    DONE,
    INTERRUPTED,
    MISSION,
    PHYSICS,
    STAGES,
    WAITING,
    FlightRecord,
)
from uwsim.flight.results import MAP, RESULT_FILES, write_results
from uwsim.flight.setup import Setup, Watched, mapping, sampling
from uwsim.flight.terminal import Show
from uwsim.mapping import OccupancyMap
from uwsim.missions.own_vehicle import Event, OwnVehicle
from uwsim.simulator.link_traffic import link_rows

if TYPE_CHECKING:
    from uwsim.flight.pinging import MapMaker


class Flight:
    """A single flight, from its setup to its results."""

    def __init__(self, setup: Setup) -> None:
        self._setup, self._sim = setup, setup.sim
        self._autosave = setup.autosave or FlightAutosave(0.0)
        self._began_s = time.perf_counter()
        self._timer = WallTimer((*STAGES, WAITING))
        self._begun_tick = self._sim.tick
        self._maker: MapMaker | None = None
        self._begun: Begun | None = None
        self._has_made_way = False

    @property
    def progress(self) -> float | None:
        """The fraction of the mission flown so far, 0..1; None if unknown."""
        return None if self._begun is None else self._begun.progress

    def run(self) -> FlightRecord:
        """Fly and write the results; then, if the mission failed, raise its error."""
        setup = self._setup
        self._log = MissionLog(setup.out)
        attachments = list(setup.attachments.values())
        try:
            for each in attachments:
                each.timer = self._timer
                each.start()
            with setup.screen.flight(f"flying {setup.mission.title} in {self._sim.scenario.name}") as show:
                flown = self._flown(show)
            for each in attachments:
                flown = each.ended(flown)
        finally:
            self._log.close()
            unwritten = [error for each in attachments if (error := each.try_close()) is not None]
        flown = self._verified(flown)
        if setup.out is not None:
            flown = self._written(flown, setup.out)
        if flown.error is not None:
            raise flown.error
        if unwritten:
            raise unwritten[0]
        return flown

    def _make_way(self, out: Path) -> None:
        """Remove the results of an earlier flight, which would not match this flight's map, before the first of it."""
        if not self._has_made_way:
            remove_stale_results(out, (MAP, *RESULT_FILES), self._setup.screen)
        self._has_made_way = True

    def _verified(self, flown: FlightRecord) -> FlightRecord:
        """Return the record, with the result of comparing its map with stock OctoMap's if requested."""
        reference = None if self._setup.mapping is None else self._setup.mapping.reference
        if reference is None or flown.occupancy is None or self._autosave.in_haste:
            return flown
        same = all(flown.occupancy.to_bytes(kind) == reference.to_bytes(kind) for kind in ("ot", "bt"))
        return replace(flown, verified=same)

    def _written(self, flown: FlightRecord, out: Path) -> FlightRecord:
        """Write the results; return the record with the map's score."""
        setup = self._setup
        if (flown.interrupted or flown.error is not None) and is_empty(flown.occupancy) and (out / MAP).exists():
            setup.screen.message(f"{out}: nothing was mapped: its {MAP} is that of an earlier flight")
            return flown
        self._make_way(out)
        ahead = None if setup.mapping is None else setup.mapping.ahead
        report = "none" if self._autosave.in_haste else setup.report
        flown = write_results(flown, self._sim, out, report, setup.screen, ahead=ahead)
        if flown.interrupted:
            setup.screen.message(f"interrupted; {out} holds everything flown so far")
        return flown

    def _flown(self, show: Show | None) -> FlightRecord:
        """Fly until the flight ends, for whatever reason; return its record."""
        setup, sim = self._setup, self._sim
        warn_of_left_out(setup.lanes_left_out)
        self._clock = clock = self._new_clock(show)
        own = {name: self._own_vehicle(name, clock) for name in setup.names}
        self._log_event("", "begun", {"mission": setup.mission.title, "scenario": sim.scenario.name, "seed": sim.seed})
        with ExitStack() as stack:
            stack.enter_context(self._autosave.flying())
            watched = Watched(setup, own, self._timer, self._begun_tick)
            self._sampler = stack.enter_context(sampling(watched, self._log_event))
            for each in setup.attachments.values():
                stack.enter_context(each.flying())
            end = run_to_end(lambda: self._result_of_mission(watched), setup.mission.file)
            for name in setup.names:
                sim.vehicles[name].set_effort()
        self._log_event("", "ended", {"because": end.because})
        record = self._record(end)
        return record if self._maker is None else self._maker.recorded(record)

    def _result_of_mission(self, watched: Watched) -> Any:
        """Fly the mission while its map is built; return its result."""
        with mapping(watched) as self._maker, self._timer.measure(MISSION):
            self._begun = self._setup.mission.begun(watched.own, self._clock, self._setup.plan)
            return self._begun.run()

    def _record(self, end: End) -> FlightRecord:
        """Return the record of the flight, without its map data."""
        setup, sim = self._setup, self._sim
        is_limited = setup.time_limit_s is not None and end.because == self._clock.end_because
        return FlightRecord(
            mission=setup.mission.title,
            scenario=sim.scenario.name,
            seed=sim.seed,
            estimate=setup.estimate,
            step_s=sim.step_s,
            ended_because=end.because,
            ended_early=end.because != DONE and not is_limited,
            simulated_s=(sim.tick - self._begun_tick) * sim.step_s,
            wall_s=time.perf_counter() - self._began_s,
            events=self._log.events,
            samples=self._sampler.samples(),
            budgets_m=self._budgets_m(),
            result=end.result,
            error=end.error,
            threads=sim.threads,
            stage_wall_s=self._timer.wall_s,
            link=link_rows(sim),
            planned=setup.mission.make is not None,
            lanes_left_out=setup.lanes_left_out,
        )

    def _budgets_m(self) -> dict[str, dict[str, Floats]]:
        """Return which metre of each estimated position comes from what, now."""
        names = self._setup.names if self._setup.estimate == "filter" else ()
        return {name: self._sim.vehicles[name].navigation.steering.budget for name in names}

    def _new_clock(self, show: Show | None) -> FlightClock:
        """Return a clock for the mission that ends the flight at its time limit."""
        sim, limit_s = self._sim, self._setup.time_limit_s
        limit_is_battery = limit_s is None and any(entry.battery is None for entry in sim.scenario.vehicles)
        if limit_s is None:
            limit_s = sim.scenario.mission_time_s
        limit = BATTERY_EMPTY if limit_is_battery else f"the time limit of {limit_s:g} s is over"
        end_tick = self._begun_tick + max(1, math.ceil(limit_s / sim.step_s - 1e-6))
        return FlightClock(sim, end_tick, limit, lambda: self._on_pause(show), self._timer.measure(PHYSICS))

    def _own_vehicle(self, name: str, clock: FlightClock) -> OwnVehicle:
        hull = self._sim.vehicles[name]
        estimate = hull.navigation.steering if self._setup.estimate == "filter" else None
        return OwnVehicle(hull, clock, estimate=estimate, hear=self._log.add)

    def _log_event(self, vehicle: str, event: str, values: dict[str, Any]) -> None:
        self._log.add(Event(self._sim.time_s, vehicle, event, values))

    def _on_pause(self, show: Show | None) -> None:
        """Show progress, save the map if a save is due, and end the flight if a stop was requested."""
        begun, out = self._begun, self._setup.out
        stop = self._autosave.stop_requested()
        if begun is not None and show is not None:
            show(begun.progress, self._sim.time_s)
        if self._maker is not None and out is not None and not stop and self._autosave.due():
            self._save(self._maker, out)
        if stop:
            raise FlightOverError(INTERRUPTED)

    def _save(self, maker: MapMaker, out: Path) -> None:
        """Write the map, as soon as it contains all pings so far."""

        def write() -> None:
            with self._timer.measure(AUTOSAVE):
                self._autosave.save(lambda: self._write_map(maker.setup.occupancy, out))

        maker.when_mapped(write)

    def _write_map(self, occupancy: OccupancyMap, out: Path) -> None:
        if not is_empty(occupancy):
            self._make_way(out)
        elif (out / MAP).exists():
            return
        occupancy.write(out / MAP)


def is_empty(occupancy: OccupancyMap | None) -> bool:
    """Return whether this is a map in which there is nothing yet, for which no earlier one makes way."""
    return occupancy is not None and occupancy.bounds() is None
