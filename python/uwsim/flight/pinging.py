"""Builds maps in flight: each mapping vehicle pings at a fixed rate, and its processing chain inserts every ping."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.wall_timer import WallTimer
from uwsim.flight.coverage import GrowthRow, GrowthWatch, scored_area_m
from uwsim.flight.log import PANEL_WARNINGS, PingLog
from uwsim.flight.record import CODEC, CONVERSION, RAYS, FlightRecord
from uwsim.mapping import OccupancyMap
from uwsim.mapping.map_filler import MapFiller
from uwsim.mapping.ping_to_map import PingToMap, depth_string
from uwsim.mapping.ranging import place_deviation_m
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.build.multibeam import map_voxel_m, ping_chain
from uwsim.scoring.true_surface import SurfaceAhead
from uwsim.simulator.simulator import Simulator

PING_RATE_HZ = 10.0  # for scenarios without a survey


def chain_of(
    sim: Simulator,
    vehicle: str,
    filler: MapFiller,
    filters: bool,
    *,
    timer: WallTimer | None = None,
    transmit: Callable[[str], str] | None = None,
) -> PingToMap:
    """Return the processing chain from a vehicle's pings to a map. filters: whether to discard outliers."""
    (entry,) = (entry for entry in sim.scenario.vehicles if entry.name == vehicle)
    sonar = sim.vehicles[vehicle].sonar
    wire = depth_string(sonar.model, transmit)
    return ping_chain(
        sim.scenario,
        entry.model,
        sonar.model,
        in_physics=sonar.mode == "physics",
        outlier_filter=filters,
        voxel_m=filler.occupancy.resolution_m,
        filler=filler,
        wire=wire if timer is None else timer.timed(CODEC, wire),
    )


def filters_outliers(sim: Simulator, vehicle: str, asked: bool | None) -> bool:
    """Return whether to filter outliers: as requested, else as the scenario specifies, else only in physics mode.

    Raises ScenarioError if the scenario limits uncertainties that the sonar does not provide.
    """
    survey, in_physics = sim.scenario.survey, sim.vehicles[vehicle].sonar.mode == "physics"
    if survey is not None and survey.max_uncertainty_m is not None and not in_physics:
        with sim.scenario.source_file.errors_at("survey", "max_uncertainty_m"):
            raise ScenarioError(
                f"survey.max_uncertainty_m = {survey.max_uncertainty_m:g} m: needs a sonar with `mode: physics`"
            )
    if asked is None and survey is not None:
        asked = survey.outlier_filter
    return in_physics if asked is None else asked


def requested_interval_s(sim: Simulator) -> float:
    """Return the time between pings requested by the scenario."""
    return 1.0 / (PING_RATE_HZ if sim.scenario.survey is None else sim.scenario.survey.ping_rate_hz)


def ping_interval_s(sim: Simulator, vehicle: str) -> float:
    """Return the scenario's ping interval, or the two-way travel time, rounded up to whole steps, if that is longer."""
    least_s = 1.0 / sim.vehicles[vehicle].sonar.ping_rate_max_hz
    return max(requested_interval_s(sim), math.ceil(least_s / sim.step_s) * sim.step_s)


def ping_steps(sim: Simulator, vehicle: str) -> int:
    """Return the number of steps between pings: the ping interval in steps, never below the travel time."""
    return max(1, round(ping_interval_s(sim, vehicle) / sim.step_s))


def survey_area_m(sim: Simulator) -> Floats | None:
    """Return the polygon (k, 2) of the scenario's survey, if it has one."""
    return None if sim.scenario.survey is None else np.asarray(sim.scenario.survey.area_m, np.float64)


def default_voxel_m(sim: Simulator) -> float:
    """Return the scenario's voxel edge length."""
    return map_voxel_m(sim.scenario)


def require_sonar(scenario: Scenario, vehicle: str) -> None:
    """Raise ValueError unless the vehicle has a sonar for mapping."""
    if any(entry.name == vehicle and entry.model.sonar is None for entry in scenario.vehicles):
        raise ValueError(f"vehicle '{vehicle}': carries no sonar to map with")


SURVEYED = ("telemetry", "placed_ping")
"""Name endings of the channels that a surveying vehicle sends over a link."""
TakePing = Callable[[_core.Ping, _core.Telemetry, Floats], object]
"""A function called with each ping, the vehicle's panel and the world_from_body (4, 4) used for the map."""


@dataclass(frozen=True)
class MapSetup:
    """How the map of a flight is built.

    occupancy: the map to fill. reference: a second map for comparison, into which every scan is inserted individually.
    outlier_filter: overrides the scenario's setting. transmit: see depth_string. growth: whether to measure the map as
    it grows. ahead: examines the true surface while
    the map thread is idle, so that scoring takes less time. on_ping: called for each ping.
    """

    occupancy: OccupancyMap
    reference: OccupancyMap | None = None
    outlier_filter: bool | None = None
    transmit: Callable[[str], str] | None = None
    growth: bool = True
    ahead: SurfaceAhead | None = None
    on_ping: tuple[TakePing, ...] = ()


class Pinger:
    """Takes one vehicle's pings, as an Observer of the simulator's journal.

    vehicle: the vehicle as seen by the mission; the map is built from its estimated poses.
    """

    def __init__(
        self, sim: Simulator, vehicle: OwnVehicle, chain: PingToMap, timer: WallTimer, log: PingLog,
        on_ping: tuple[TakePing, ...],
    ) -> None:  # fmt: skip
        self._sim, self._vehicle, self._chain, self._on_ping = sim, vehicle, chain, on_ping
        self._hull = sim.vehicles[vehicle.name]
        self._rays, self._conversion = timer.measure(RAYS), timer.measure(CONVERSION)
        self.log = log
        self.steps = ping_steps(sim, vehicle.name)
        self.due_tick = sim.tick + self.steps

    def observe(self) -> None:
        """Take a ping and pass it to the chain, the log and on_ping."""
        self.due_tick = self._sim.tick + self.steps
        with self._rays:
            ping = self._hull.sonar.ping()
        true_body, panel = self._hull.pose.world_from_body, self._hull.telemetry()
        true_sonar = ping.world_from_sonar  # read once, since each access creates an array
        body, sonar, mapped_from_m = true_body, true_sonar, None
        if self._vehicle.estimate is not self._hull:
            body = np.asarray(self._vehicle.pose.world_from_body, np.float64)
            sonar = body @ np.linalg.inv(true_body) @ true_sonar
            mapped_from_m = sonar[:3, 3]
        deviation_m = place_deviation_m(ping)
        with self._conversion:
            points = self._chain.insert(ping.ranges_m, body, sonar, self._sim.time_s, deviation_m)
        self.log.add(ping, points, panel, true_sonar, mapped_from_m)
        for take in self._on_ping:
            take(ping, panel, body)


class MapMaker:
    """Context manager that builds the map of a flight from the pings of one or several vehicles.

    With one vehicle the map is filled on a separate thread; several vehicles fill it in turn on the flying thread, so
    that the map's bytes do not depend on scheduling.
    """

    def __init__(
        self, sim: Simulator, vehicles: Mapping[str, OwnVehicle], setup: MapSetup, timer: WallTimer, *,
        begun_tick: int,
    ) -> None:  # fmt: skip
        self.setup = setup
        self._sim, self._stack = sim, ExitStack()
        self._filters = {name: filters_outliers(sim, name, setup.outlier_filter) for name in vehicles}
        alone = len(vehicles) == 1
        ahead = setup.ahead.look_at if setup.ahead is not None and alone else None
        self._fillers: list[MapFiller] = []
        self.pingers: dict[str, Pinger] = {}
        for name, vehicle in vehicles.items():
            sonar = sim.vehicles[name].sonar
            sonar.map_as(self._filters[name], setup.occupancy.resolution_m)  # also for maps elsewhere, as over a link
            filler = MapFiller(
                setup.occupancy, sonar.model.range_max_m, threads=sim.threads if alone else 1, timer=timer,
                reference=setup.reference, on_mapped=ahead,
            )  # fmt: skip
            chain = chain_of(sim, name, filler, self._filters[name], timer=timer, transmit=setup.transmit)
            log = PingLog(survey_area_m(sim))
            self._fillers.append(filler)
            self.pingers[name] = Pinger(sim, vehicle, chain, timer, log, setup.on_ping)
        self._growth = GrowthWatch(sim, setup.occupancy, self.when_mapped, begun_tick=begun_tick)

    @property
    def growth(self) -> tuple[GrowthRow, ...]:
        """The measurements of the map so far."""
        return tuple(self._growth.rows)

    def when_mapped(self, job: Callable[[], None]) -> None:
        """Run a job as soon as the map contains exactly the pings taken so far."""
        for filler in self._fillers[:-1]:
            filler.finish()
        self._fillers[-1].when_mapped(job)

    def recorded(self, record: FlightRecord) -> FlightRecord:
        """Return the flight's record with its map data filled in."""
        sim, (first, *_) = self._sim, self.pingers
        logs, occupancy = {name: pinger.log for name, pinger in self.pingers.items()}, self.setup.occupancy
        true_m = {name: log.path_world_m for name, log in logs.items()}
        warnings = sim.scenario.warnings
        return replace(
            record,
            sonar_model=next(each.sonar.title for each in sim.scenario.vehicles if each.name == first),
            occupancy=occupancy,
            voxel_m=occupancy.resolution_m,
            pings_world_m={name: log.mapped_path_m for name, log in logs.items()},
            true_pings_world_m=true_m,
            echo_count=sum(log.echo_count for log in logs.values()),
            range_max_m=max(float(sim.vehicles[name].sonar.model.range_limit_m) for name in logs),
            outlier_filter=any(self._filters.values()),
            ping_interval_s=ping_interval_s(sim, first),
            ping_interval_requested_s=requested_interval_s(sim),
            pings_with_warning={
                name: sum(log.pings_with_warning[name] for log in logs.values()) for name in PANEL_WARNINGS
            },
            warning_limits_m={"range": warnings.range_m, "proximity": warnings.proximity_m},
            sample_ping=logs[first].sample,
            map_growth=self.growth,
            area_world_m=scored_area_m(survey_area_m(sim), np.concatenate(list(true_m.values()))),
        )

    def __enter__(self) -> MapMaker:
        for filler, pinger in zip(self._fillers, self.pingers.values(), strict=True):
            self._stack.enter_context(filler)
            self._attach(pinger)
        if self.setup.growth:
            self._attach(self._growth)  # after the pings of its tick
        return self

    def _attach(self, observer: Pinger | GrowthWatch) -> None:
        self._sim.journal.attach(observer)
        self._stack.callback(self._sim.journal.detach, observer)

    def __exit__(self, *error: Any) -> None:
        """Wait until the map is filled."""
        self._stack.__exit__(*error)
