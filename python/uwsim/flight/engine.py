"""The flight engine: flies any mission in a simulator, with log, samples, map, link, recording, saves and results."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uwsim.base.wall_timer import WallTimer
from uwsim.flight.autosave import FlightAutosave
from uwsim.flight.checkpoint import MAP, FlightCheckpoint, is_empty
from uwsim.flight.clock import FlightClock, FlightOverError
from uwsim.flight.end import End, run_to_end
from uwsim.flight.folder import remove_stale_results
from uwsim.flight.mission_log import MissionLog
from uwsim.flight.missions import Begun, warn_of_left_out
from uwsim.flight.record import BATTERY_EMPTY, DONE, INTERRUPTED, Array, FlightRecord
from uwsim.flight.request import FlightRequest
from uwsim.flight.results import RESULT_FILES, write_results
from uwsim.flight.saved_flight import SavedFlight, SavedMission, state_digest
from uwsim.flight.setup import Setup
from uwsim.flight.stages import AUTOSAVE, MISSION, PHYSICS, STAGES, WAITING
from uwsim.flight.terminal import Show
from uwsim.flight.watched import Watched, mapping, sampling
from uwsim.missions.own_vehicle import Event, OwnVehicle
from uwsim.simulator.link_traffic import link_rows
from uwsim.simulator.simulator import Simulator

if TYPE_CHECKING:
    from uwsim.flight.pinging import MapMaker


class Flight:
    """A single flight, from its setup to its results."""

    def __init__(self, setup: Setup) -> None:
        self._setup, self._sim, self._saved = setup, setup.sim, setup.saved
        self._autosave = setup.autosave or FlightAutosave(0.0)
        self._began_s = time.perf_counter()
        self._timer = WallTimer((*STAGES, WAITING), setup.saved.stage_wall_s if setup.saved is not None else None)
        if (saved := self._saved) is not None:
            self._began_s -= saved.wall_s
            if saved.mission is not None:
                self._sim.restore_state(saved.simulation)
        self._begun_tick = self._restored.begun_tick if self._restored else self._sim.tick
        self._repeating = saved is not None and saved.mission is None
        self._maker: MapMaker | None = None
        self._begun: Begun | None = None
        self._has_made_way = False

    @property
    def progress(self) -> float | None:
        """The fraction of the mission flown so far, 0..1; None if unknown."""
        return None if self._begun is None else self._begun.progress

    @property
    def _restored(self) -> SavedMission | None:
        return None if self._saved is None else self._saved.mission

    def run(self) -> FlightRecord:
        """Fly and write the results; then, if the mission failed, raise its error."""
        setup = self._setup
        self._log = MissionLog(setup.out, self._restored.events if self._restored else ())
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
            names = RESULT_FILES if self._saved is not None else (MAP, *RESULT_FILES)
            remove_stale_results(out, names, self._setup.screen)
        self._has_made_way = True

    def _verified(self, flown: FlightRecord) -> FlightRecord:
        """Return the record, with the result of comparing its map with stock OctoMap's if requested."""
        reference = None if self._setup.mapping is None else self._setup.mapping.reference
        if reference is None or flown.occupancy is None or self._autosave.in_haste:
            return flown
        same = all(flown.occupancy.to_bytes(kind) == reference.to_bytes(kind) for kind in ("ot", "bt"))
        return replace(flown, verified=same)

    def _written(self, flown: FlightRecord, out: Path) -> FlightRecord:
        """Write the results, then remove the saved flight, so that --resume can repeat a failed report."""
        setup, checkpoint = self._setup, FlightCheckpoint(out)
        if (flown.interrupted or flown.error is not None) and is_empty(flown.occupancy) and (out / MAP).exists():
            setup.screen.message(f"{out}: nothing was mapped: its {MAP} is that of an earlier flight")
            return flown
        self._make_way(out)
        is_saved = checkpoint.exists and self._autosave.failure is None
        ahead = None if setup.mapping is None else setup.mapping.ahead
        report = "none" if self._autosave.in_haste else setup.report
        flown = write_results(flown, self._sim, out, report, setup.screen, ahead=ahead, is_saved=is_saved)
        if flown.interrupted:
            then = "; --resume continues" if is_saved else ""
            setup.screen.message(f"interrupted; {out} holds everything flown so far{then}")
        elif not self._repeating:
            checkpoint.remove()
        return flown

    def _flown(self, show: Show | None) -> FlightRecord:
        """Fly until the flight ends, for whatever reason; return its record."""
        setup, sim = self._setup, self._sim
        warn_of_left_out(setup.lanes_left_out)
        self._clock = clock = self._new_clock(show)
        own = {name: self._own_vehicle(name, clock) for name in setup.names}
        if not self._restored:
            self._log_event(
                "", "begun", {"mission": setup.mission.title, "scenario": sim.scenario.name, "seed": sim.seed}
            )
        with ExitStack() as stack:
            stack.enter_context(self._autosave.flying())
            watched = Watched(setup, own, self._timer, self._begun_tick)
            self._sampler = stack.enter_context(sampling(watched, self._log_event))
            for each in setup.attachments.values():
                stack.enter_context(each.flying())
            end = run_to_end(lambda: self._result_of_mission(watched), setup.mission.file)
            if self._repeating and self._saved is not None and end.error is None and end.because != INTERRUPTED:
                raise self._saved.another_flight(sim.step_s)
            for name in setup.names:
                sim.vehicles[name].set_effort()
        self._log_event("", "ended", {"because": end.because})
        record = self._record(end)
        return record if self._maker is None else self._maker.recorded(record)

    def _result_of_mission(self, watched: Watched) -> Any:
        """Fly the mission while its map is built; return its result."""
        with mapping(watched) as self._maker, self._timer.measure(MISSION):
            self._begun = self._mission_with(watched.own)
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

    def _budgets_m(self) -> dict[str, dict[str, Array]]:
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
        phase = self._restored.clock if self._restored else None
        physics = self._timer.measure(PHYSICS)
        return FlightClock(sim, end_tick, limit, lambda: self._on_pause(show), physics, phase)

    def _own_vehicle(self, name: str, clock: FlightClock) -> OwnVehicle:
        hull = self._sim.vehicles[name]
        estimate = hull.navigation.steering if self._setup.estimate == "filter" else None
        return OwnVehicle(hull, clock, estimate=estimate, hear=self._log.add)

    def _mission_with(self, own: Mapping[str, OwnVehicle]) -> Begun:
        """Return the mission bound to its vehicles, in its saved state if there is one."""
        begun = self._setup.mission.begun(own, self._clock, self._setup.plan)
        if self._restored:
            if begun.resumable is None:
                raise ValueError(f"--resume: mission {self._setup.mission.title}: no longer has save and restore")
            begun.resumable.restore(self._restored.state)
        return begun

    def _log_event(self, vehicle: str, event: str, values: dict[str, Any]) -> None:
        self._log.add(Event(self._sim.time_s, vehicle, event, values))

    def _on_pause(self, show: Show | None) -> None:
        """Show progress, save the flight if a save is due, and end it if a stop was requested."""
        begun, request = self._begun, self._setup.request
        stop = self._autosave.stop_requested()
        if begun is not None and show is not None:
            show(begun.progress, self._sim.time_s)
        if self._repeating:
            self._repeating = not is_repeated(self._saved, self._sim)
        elif begun is not None and request is not None and self._autosave.is_on and (stop or self._autosave.due()):
            self._save(request, begun)
        if stop:
            raise FlightOverError(INTERRUPTED)

    def _save(self, request: FlightRequest, begun: Begun) -> None:
        """Save the current state of the flight, as soon as the map contains all pings so far."""
        maker, out = self._maker, self._setup.out
        assert out is not None
        now = self._now(request, begun)

        def write() -> None:
            growth = () if maker is None else maker.growth
            with self._timer.measure(AUTOSAVE):
                self._autosave.save(lambda: self._keep(now.with_growth(growth), out))

        if maker is None:
            write()
        else:
            maker.when_mapped(write)

    def _keep(self, saved: SavedFlight, out: Path) -> None:
        if saved.occupancy is not None and not is_empty(saved.occupancy):
            self._make_way(out)
        FlightCheckpoint(out).write(saved)

    def _now(self, request: FlightRequest, begun: Begun) -> SavedFlight:
        """Return the data needed to resume the flight, except the map growth."""
        state, maker, mapping = self._sim.save_state(), self._maker, self._setup.mapping
        saved = SavedFlight(
            request,
            self._sim.tick,
            state_digest(state),
            wall_s=time.perf_counter() - self._began_s,
            stage_wall_s=dict(self._timer.wall_s),
            occupancy=None if mapping is None else mapping.occupancy,
            reference=None if mapping is None else mapping.reference,
            pinging=None if maker is None else maker.save(),
        )
        if (resumable := begun.resumable) is None:
            return saved
        mission = SavedMission(
            state=resumable.save(),
            clock=self._clock.phase,
            begun_tick=self._begun_tick,
            events=list(self._log.events),
            attachments=self._saved_attachments(),
        )
        rows = {name: samples.values for name, samples in self._sampler.samples().items()}
        return replace(saved, mission=mission, simulation=state, samples=rows)

    def _saved_attachments(self) -> dict[str, dict[str, Any]]:
        found = {name: each.save() for name, each in self._setup.attachments.items()}
        return {name: state for name, state in found.items() if state is not None}


def is_repeated(saved: SavedFlight | None, sim: Simulator) -> bool:
    """Return whether a flight being repeated has reached its saved tick.

    Raises MissionError if the state at that tick differs from the saved one.
    """
    assert saved is not None
    if sim.tick < saved.tick:
        return False
    if sim.tick > saved.tick or not saved.is_state(sim.save_state()):
        raise saved.another_flight(sim.step_s)
    return True
