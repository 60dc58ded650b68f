"""fly and resume: fly a mission in a simulator, with log, samples, map and report. The job of `uwsim run`."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uwsim.flight.autosave import FlightAutosave
from uwsim.flight.checkpoint import FlightCheckpoint, SavedFlight, state_digest
from uwsim.flight.clock import FlightClock, FlightOverError
from uwsim.flight.folder import made_folder
from uwsim.flight.map_maker import MapMaker, default_voxel_m, require_sonar
from uwsim.flight.mission_file import FUNCTION, load_mission, mission_error, mission_name, with_arguments
from uwsim.flight.mission_log import MissionLog
from uwsim.flight.record import DONE, INTERRUPTED, FlightRecord
from uwsim.flight.request import ESTIMATES, EstimateKind, FlightRequest, file_digest
from uwsim.flight.results import RESULT_FILES, require_report, write_results
from uwsim.flight.samples import Sampler
from uwsim.folder_lock import alone_in, require_free
from uwsim.mapping import OccupancyMap
from uwsim.missions.own_vehicle import Event, OwnVehicle
from uwsim.missions.run import MissionFunction, begin, first_parameter
from uwsim.missions.steps import drive
from uwsim.missions.stopped import StoppedError
from uwsim.scenario import Scenario
from uwsim.scenario.fingerprint import warn_of_other_build
from uwsim.simulator import Simulator

if TYPE_CHECKING:
    from uwsim.channels import Table
    from uwsim.link import Carrier

AUTOSAVE_S = 30.0
Show = Callable[[str], AbstractContextManager[object]]


def fly(
    mission: MissionFunction | str | Path,
    scenario: str | Path | Scenario | Simulator = "lake",
    out: str | Path | None = None,
    *,
    function: str = FUNCTION,
    arguments: Mapping[str, Any] | None = None,
    vehicles: Iterable[str] = (),
    estimate: EstimateKind = "truth",
    map: bool = False,  # noqa: A002  # as the option is called
    voxel_m: float | None = None,
    close_loops: bool = False,
    seed: int | None = None,
    sonar_model: int | str | None = None,
    mission_time_s: float | None = None,
    link: str | Path | None = None,
    time_limit_s: float | None = None,
    threads: int | None = None,
    record: Path | None = None,
    record_topics: tuple[str, ...] | None = None,
    report: str = "full",
    autosave_s: float = AUTOSAVE_S,
    autosave: FlightAutosave | None = None,
    show: Show = lambda activity: nullcontext(),
) -> FlightRecord:
    """Fly a mission; return its record.

        record = fly(mission, scenario="pool")                       # a function, as in a notebook
        record = fly("my_mission.py", "lake", "out/", map=True)      # a file; results in a folder

    scenario: a name, a path, a Scenario, or a Simulator, which flies on from where it is. out: a folder for log.jsonl,
    track-VEHICLE.csv, map.bt and, by report, report.html ("full"), summary.json ("json") or neither ("none").
    arguments: for the mission's other parameters. vehicles: names; by default all if the mission takes `vehicles`, else
    the first. estimate: what vehicles know of their pose, and what the map is made with: the "truth", or that of their
    "filter" (Vehicle.estimate). close_loops: bend the filter's track after the flight until what it saw twice fits, and
    make the map again; such a flight is not saved as it flies. link: a modem, by name or file, that replaces the
    scenario's. time_limit_s: simulated; by default the scenario's mission time. record: a new recording (.mcap), of
    record_topics; by default all but pictures. show: shows an activity while a block runs.

    Raises ScenarioError or ValueError for wrong arguments before anything is written, OSError; and what the mission
    raises, for a file as MissionError, after the results of the flight until then have been written.
    """
    file = Path(mission) if isinstance(mission, str | Path) else None
    fly_it = load_mission(file, function) if file is not None else mission
    assert callable(fly_it)
    fly_it = with_arguments(fly_it, arguments or {})
    takes = first_parameter(fly_it)
    if estimate not in ESTIMATES:
        raise ValueError(f"estimate = {estimate!r}: must be one of {', '.join(ESTIMATES)}")
    require_report(report)
    if voxel_m is not None and not map:
        raise ValueError(f"voxel_m = {voxel_m} m: is without effect unless map=True")
    if time_limit_s is not None and not 0.0 < time_limit_s < math.inf:
        raise ValueError(f"time_limit_s = {time_limit_s} s: must be positive")
    if close_loops and not (map and estimate == "filter"):
        raise ValueError("close_loops: needs map=True and estimate='filter': what is true or not mapped has no loops")
    saving = autosave or FlightAutosave(autosave_s)
    if out is not None:
        require_free(Path(out))
    if isinstance(scenario, Simulator):
        given = {
            "seed": seed, "sonar_model": sonar_model, "mission_time_s": mission_time_s, "link": link,
            "threads": threads,
        }  # fmt: skip
        if ignored := [name for name, value in given.items() if value is not None]:
            raise ValueError(f"{ignored[0]}: the simulator is made already")
        sim = scenario
    else:
        with show(f"building {scenario if isinstance(scenario, str | Path) else scenario.name}"):
            sim = Simulator(
                scenario,
                seed=seed,
                sonar_model=sonar_model,
                mission_time_s=mission_time_s,
                link=link,
                threads=threads,
            )
    names = tuple(vehicles) or (tuple(sim.vehicles) if takes == "vehicles" else (sim.rov.name,))
    for name in names:
        vehicle = sim.vehicles[name]  # raises ValueError for an unknown one
        if map:
            require_sonar(sim, name)
        if estimate == "filter":
            _ = vehicle.estimate  # raises ValueError for a vehicle without an IMU
    request = None
    if file is not None and isinstance(scenario, str | Path) and not close_loops:
        request = FlightRequest(
            mission=str(file.resolve()),
            function=function,
            mission_digest=file_digest(file),
            arguments=dict(arguments or {}),
            scenario=_name_or_file(scenario),
            seed=sim.seed,
            sonar_model=sonar_model,
            mission_time_s=mission_time_s,
            link=None if link is None else _name_or_file(link),
            vehicles=names,
            estimate=estimate,
            map=map,
            voxel_m=voxel_m,
            time_limit_s=time_limit_s,
        )
    folder = None if out is None else made_folder(Path(out))
    flight = _Flight(
        sim=sim, mission=fly_it, file=file, names=names, estimate=estimate, out=folder, request=request, report=report,
        autosave=saving, time_limit_s=time_limit_s, show=show, close_loops=close_loops,
    )  # fmt: skip
    if map:
        flight.occupancy = OccupancyMap(resolution_m=voxel_m or default_voxel_m(sim))
    if folder is None:
        return flight.run(record, record_topics)
    with alone_in(folder):
        FlightCheckpoint(folder).remove()
        return flight.run(record, record_topics)


def _name_or_file(given: str | Path) -> str:
    return str(Path(given).resolve()) if Path(given).is_file() else str(given)


def resume(
    out: str | Path,
    *,
    threads: int | None = None,
    report: str = "full",
    autosave_s: float = AUTOSAVE_S,
    autosave: FlightAutosave | None = None,
    show: Show = lambda activity: nullcontext(),
) -> FlightRecord:
    """Continue the flight of a mission's file that was last saved in `out`, to the same results; see checkpoint.py.

    Raises ValueError if there is none, if the mission's file has changed, or if it does not fly as it did; OSError.
    """
    folder = Path(out)
    require_report(report)
    FlightCheckpoint(folder).require_one()
    with alone_in(folder):
        saved = FlightCheckpoint(folder).read()
        saved.request.require_same_file()
        return _resumed(saved, folder, threads, report, autosave or FlightAutosave(autosave_s), show).run()


def _resumed(
    saved: SavedFlight, folder: Path, threads: int | None, report: str, autosave: FlightAutosave, show: Show
) -> _Flight:
    request, file = saved.request, Path(saved.request.mission)
    warn_of_other_build("the saved flight", saved.build)
    with show(f"resuming {folder}"):
        sim = request.new_simulator(threads)
    mission = with_arguments(load_mission(file, request.function), request.arguments)
    flight = _Flight(
        sim=sim, mission=mission, file=file, names=request.vehicles, estimate=request.estimate, out=folder,
        request=request, report=report, autosave=autosave,
        time_limit_s=request.time_limit_s, show=show,
    )  # fmt: skip
    if request.map:
        flight.occupancy = saved.occupancy or OccupancyMap(resolution_m=request.voxel_m or default_voxel_m(sim))
    flight.saved = saved
    return flight


class _Flight:
    """A flight that is ready to begin. saved: what it continues."""

    def __init__(
        self,
        *,
        sim: Simulator,
        mission: MissionFunction,
        file: Path | None,
        names: tuple[str, ...],
        estimate: EstimateKind,
        out: Path | None,
        request: FlightRequest | None,
        report: str,
        autosave: FlightAutosave,
        time_limit_s: float | None,
        show: Show,
        close_loops: bool = False,
    ) -> None:
        self._sim, self._mission, self._file, self._names = sim, mission, file, names
        self._title = mission_name(mission, file)
        self._estimate, self._out, self._request, self._report = estimate, out, request, report
        self._autosave, self._show, self._close_loops = autosave, show, close_loops
        self._limited = time_limit_s is not None
        self._limit_s = sim.scenario.mission_time_s if time_limit_s is None else time_limit_s
        self.occupancy: OccupancyMap | None = None
        self.saved: SavedFlight | None = None
        self._repeating = False
        self._maker: MapMaker | None = None
        self._table: Table | None = None

    def run(self, record: Path | None = None, topics: tuple[str, ...] | None = None) -> FlightRecord:
        """Fly, write the results whatever happened, and raise what the mission raised."""
        if self._out is not None:
            for stale in RESULT_FILES:
                (self._out / stale).unlink(missing_ok=True)
        self._log = MissionLog(self._out)
        self._begun_s, began_s = self._sim.time_s, time.perf_counter()
        recorder = self._recorder(record, topics)
        carrier = self._carrier()
        try:
            with self._show(f"flying {self._title}"), self._autosave.flying():
                flown = self._flown(began_s)
        finally:
            self._log.close()
            if carrier is not None:
                carrier.close()
            unwritten = None if recorder is None else recorder.try_close()
        if self._close_loops and self._maker is not None:
            from uwsim.flight.closed_flight import closed_flight  # here, since scipy takes long to import

            with self._show("closing loops"):
                flown = closed_flight(flown, self._sim, self._maker.tracks, self._maker.true_paths_m)
        if self._out is not None:
            report = "none" if self._autosave.in_haste else self._report
            flown = write_results(flown, self._sim, self._out, report, self._show)
            if not flown.interrupted:
                FlightCheckpoint(self._out).remove()
        if flown.error is not None:
            raise flown.error
        if unwritten is not None:
            raise unwritten
        return flown

    def _table_of_channels(self) -> Table:
        """Return the simulator's channels, the same for recorder and link."""
        from uwsim.channels import Table

        if self._table is None:
            self._table = Table(self._sim)
        return self._table

    def _carrier(self) -> Carrier | None:
        """Begin to tell the station what the vehicles say, if the scenario has a link."""
        if self._sim.link is None:
            return None
        from uwsim.link import Carrier

        return Carrier(self._sim, self._table_of_channels()).start()

    def _recorder(self, record: Path | None, topics: tuple[str, ...] | None) -> Any:
        if record is None:
            return None
        from uwsim.recording.recorder import MAP_TYPE, Recorder  # here, since recording formats take long to import

        table = self._table_of_channels()
        costly = [c.name for c in table.channels if c.late or c.type == MAP_TYPE] if topics is None else []
        return Recorder(self._sim, record, topics=topics, without=costly, shared=table).start()

    def _flown(self, began_s: float) -> FlightRecord:
        sim = self._sim
        end_tick = sim.tick + max(1, math.ceil(self._limit_s / sim.step_s - 1e-6))
        limit = f"the {'time limit' if self._limited else 'mission time'} of {self._limit_s:g} s is over"
        clock = FlightClock(sim, end_tick, limit, self._on_pause)
        own = {name: self._own_vehicle(name, clock) for name in self._names}
        self._hear("", "begun", {"mission": self._title, "scenario": sim.scenario.name, "seed": sim.seed})
        sampler = Sampler(sim, own, self._hear)
        self._repeating = self.saved is not None
        result, error, because = None, None, DONE
        with ExitStack() as stack:
            sim.journal.attach(sampler)
            stack.callback(sim.journal.detach, sampler)
            if self.occupancy is not None:
                self._maker = stack.enter_context(self._map_maker(own))
            try:
                result = drive(begin(self._mission, own), clock)
            except FlightOverError as over:
                because = str(over)
            except StoppedError as stop:
                because = str(stop)
            except KeyboardInterrupt:
                because = INTERRUPTED
            except Exception as raised:
                error = raised if self._file is None else mission_error(raised, self._file)
                because = f"the mission raised {type(raised).__name__}: {error}"
            if self._repeating and error is None and self.saved is not None:
                raise self.saved.another_flight(sim.step_s)
            for name in self._names:
                sim.vehicles[name].set_effort()
        self._hear("", "ended", {"because": because})
        maker = self._maker
        from uwsim.link.table import link_rows  # here, since channels take long to import

        return FlightRecord(
            mission=self._title,
            scenario=sim.scenario.name,
            seed=sim.seed,
            estimate=self._estimate,
            step_s=sim.step_s,
            ended_because=because,
            ended_early=because != DONE and not (self._limited and because == limit),
            simulated_s=sim.time_s - self._begun_s,
            wall_s=time.perf_counter() - began_s,
            events=self._log.events,
            samples=sampler.samples(),
            result=result,
            error=error,
            occupancy=self.occupancy,
            pings_world_m={} if maker is None else maker.paths_world_m,
            echo_count=0 if maker is None else maker.echo_count,
            range_max_m=0.0 if maker is None else maker.range_max_m,
            map_growth=() if maker is None else maker.growth,
            link=link_rows(sim),
        )

    def _own_vehicle(self, name: str, clock: FlightClock) -> OwnVehicle:
        hull = self._sim.vehicles[name]
        estimate = hull.estimate if self._estimate == "filter" else None
        return OwnVehicle(hull, clock, estimate=estimate, hear=self._log.add)

    def _map_maker(self, own: Mapping[str, OwnVehicle]) -> MapMaker:
        assert self.occupancy is not None
        saved = self.saved
        return MapMaker(
            self._sim,
            own,
            self.occupancy,
            first_tick=-1 if saved is None else saved.tick,
            flown_before={} if saved is None else saved.paths_world_m or {},
            echoes_before=0 if saved is None else saved.echo_count,
            keep=self._close_loops,
            growth_before=() if saved is None else saved.growth,
        )

    def _hear(self, vehicle: str, event: str, values: dict[str, Any]) -> None:
        self._log.add(Event(self._sim.time_s, vehicle, event, values))

    def _on_pause(self) -> None:
        """Save the flight when that is due, and end it on Ctrl-C."""
        saved = self.saved
        if self._repeating and saved is not None:
            if self._sim.tick >= saved.tick:
                if self._sim.tick > saved.tick or not saved.is_state(self._sim.save_state()):
                    raise saved.another_flight(self._sim.step_s)
                self._repeating = False
            elif self._autosave.stop_requested():
                raise FlightOverError(INTERRUPTED)
            return
        stop = self._autosave.stop_requested()
        if self._out is not None and self._request is not None and (stop or self._autosave.due()):
            self._save(self._request, FlightCheckpoint(self._out))
        if stop:
            raise FlightOverError(INTERRUPTED)

    def _save(self, request: FlightRequest, checkpoint: FlightCheckpoint) -> None:
        now = SavedFlight(request, self._sim.tick, state_digest(self._sim.save_state()))
        if (maker := self._maker) is None:
            self._autosave.save(lambda: checkpoint.write(now))
            return
        now = replace(now, occupancy=maker.occupancy, paths_world_m=maker.paths_world_m, echo_count=maker.echo_count)
        maker.when_mapped(lambda: self._autosave.save(lambda: checkpoint.write(replace(now, growth=maker.growth))))
