"""Makes a map in flight: each mapping vehicle's sonar pings at a fixed rate, and every ping goes through the chain."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.flight.map_growth import GrowthRow, GrowthWatch
from uwsim.mapping import OccupancyMap
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.scenario import vehicle_hull
from uwsim.simulator import Simulator
from uwsim.survey.ping_to_map import HullBox, PingToMap

if TYPE_CHECKING:
    from uwsim.closure import PingTrack
    from uwsim.survey.closed_map import PingKeeper

HULL_MARGIN_M = 0.05
PING_RATE_HZ, VOXEL_M = 10.0, 0.2  # of scenarios without a survey


class Mapper:
    """One vehicle's pings: an Observer of the simulator's journal.

    vehicle: as the mission sees it; the map is made with its estimated poses. path_world_m: the sonar's estimated
    position at each ping. keeper: keeps the pings, too, so that the map can be made again; then true_path_m has the
    vehicle's true positions.
    """

    def __init__(
        self, sim: Simulator, vehicle: OwnVehicle, chain: PingToMap, first_tick: int, keeper: PingKeeper | None
    ) -> None:
        self._sim, self._vehicle, self._chain = sim, vehicle, chain
        self._hull = sim.vehicles[vehicle.name]
        self._steps = max(1, round(ping_interval_s(sim, vehicle.name) / sim.step_s))
        self.due_tick = sim.tick + self._steps
        while self.due_tick <= first_tick:
            self.due_tick += self._steps
        self.keeper = keeper
        self.path_world_m: list[NDArray[np.float64]] = []
        self.true_path_m: list[NDArray[np.float64]] = []
        self.echo_count = 0

    def observe(self) -> None:
        """Ping, and pass the ping on."""
        self.due_tick = self._sim.tick + self._steps
        ping = self._hull.sonar.ping()
        true_body = self._hull.pose.world_from_body
        body, sonar = np.asarray(self._vehicle.pose.world_from_body, np.float64), ping.world_from_sonar
        if self._vehicle.estimate is not self._hull:
            sonar = body @ np.linalg.inv(true_body) @ sonar
        deviation_m = ping.deviation_m if isinstance(ping, _core.PhysicsPing) else None
        points = self._chain.insert(ping.ranges_m, body, sonar, self._sim.time_s, deviation_m)
        self.path_world_m.append(sonar[:3, 3].copy())
        self.echo_count += len(points)
        if self.keeper is not None:
            self.keeper.keep(ping, body)
            self.true_path_m.append(true_body[:3, 3])

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Nothing depends on commands."""


class MapMaker:
    """The map of a flight, made by one vehicle or by several together. A context manager.

    first_tick: pings at this tick and before are in the map already. keep: keep all pings (`tracks`). With one vehicle
    the map is filled on a thread of its own; several take turns, so that the map's bytes do not depend on threads.
    """

    def __init__(
        self,
        sim: Simulator,
        vehicles: Mapping[str, OwnVehicle],
        occupancy: OccupancyMap,
        *,
        first_tick: int,
        flown_before: Mapping[str, NDArray[np.float64]],
        echoes_before: int,
        keep: bool = False,
        growth_before: tuple[GrowthRow, ...] = (),
    ) -> None:
        self.occupancy = occupancy
        self._sim, self._stack = sim, ExitStack()
        self._before, self._echoes_before = dict(flown_before), echoes_before
        threads = sim.threads if len(vehicles) == 1 else 1
        self._chains = [chain_of(sim, name, occupancy, threads) for name in vehicles]
        self._mappers = {
            name: Mapper(sim, vehicle, chain, first_tick, _keeper(sim, name) if keep else None)
            for (name, vehicle), chain in zip(vehicles.items(), self._chains, strict=True)
        }
        self._growth = GrowthWatch(sim, occupancy, self.when_mapped, first_tick=first_tick, rows=growth_before)

    @property
    def growth(self) -> tuple[GrowthRow, ...]:
        """How the map has grown, as far as it is measured."""
        return tuple(self._growth.rows)

    def when_mapped(self, job: Callable[[], None]) -> None:
        """Run a job when the map holds all pings so far and none later."""
        for chain in self._chains[:-1]:
            chain.finish()
        self._chains[-1].when_mapped(job)

    @property
    def paths_world_m(self) -> dict[str, NDArray[np.float64]]:
        """Each vehicle's sonar's estimated position at each ping, (n, 3)."""
        now = {name: np.array(mapper.path_world_m).reshape(-1, 3) for name, mapper in self._mappers.items()}
        return {name: np.concatenate([self._before.get(name, np.empty((0, 3))), path]) for name, path in now.items()}

    @property
    def tracks(self) -> dict[str, PingTrack]:
        """The pings that were kept, by vehicle."""
        return {name: mapper.keeper.track for name, mapper in self._mappers.items() if mapper.keeper is not None}

    @property
    def true_paths_m(self) -> dict[str, NDArray[np.float64]]:
        """Each vehicle's true positions at the pings that were kept, (n, 3)."""
        return {name: np.array(mapper.true_path_m).reshape(-1, 3) for name, mapper in self._mappers.items()}

    @property
    def echo_count(self) -> int:
        """Echoes in the map."""
        return self._echoes_before + sum(mapper.echo_count for mapper in self._mappers.values())

    @property
    def range_max_m(self) -> float:
        """The longest range of the sonars."""
        return max(float(chain.model.range_limit_m) for chain in self._chains)

    def __enter__(self) -> MapMaker:
        for chain, mapper in zip(self._chains, self._mappers.values(), strict=True):
            self._stack.enter_context(chain)
            self._sim.journal.attach(mapper)
            self._stack.callback(self._sim.journal.detach, mapper)
        self._sim.journal.attach(self._growth)  # after the pings of its tick
        self._stack.callback(self._sim.journal.detach, self._growth)
        return self

    def __exit__(self, *error: Any) -> None:
        """Wait until the map is filled."""
        self._stack.__exit__(*error)


def _keeper(sim: Simulator, vehicle: str) -> PingKeeper:
    from uwsim.survey.closed_map import PingKeeper  # here, since scipy takes long to import

    return PingKeeper(sim, sim.vehicles[vehicle])


def chain_of(sim: Simulator, vehicle: str, occupancy: OccupancyMap, threads: int) -> PingToMap:
    """Return the chain from a vehicle's pings to a map."""
    (entry,) = (entry for entry in sim.scenario.vehicles if entry.name == vehicle)
    sonar, survey = sim.vehicles[vehicle].sonar, sim.scenario.survey
    in_physics = sonar.mode == "physics"
    filters = in_physics if survey is None or survey.outlier_filter is None else survey.outlier_filter
    limit_m = None if survey is None else survey.max_uncertainty_m
    vertices, _ = vehicle_hull(entry.model)
    return PingToMap(
        occupancy,
        sonar.model,
        HullBox(vertices.min(axis=0) - HULL_MARGIN_M, vertices.max(axis=0) + HULL_MARGIN_M),
        threads=threads,
        outlier_filter=filters,
        max_uncertainty_m=(limit_m or occupancy.resolution_m / 2.0) if filters and in_physics else None,
    )


def ping_interval_s(sim: Simulator, vehicle: str) -> float:
    """Return the time between pings: the scenario's, or what sound needs to the maximum range and back."""
    rate_hz = sim.scenario.survey.ping_rate_hz if sim.scenario.survey is not None else PING_RATE_HZ
    return max(1.0 / rate_hz, 1.0 / sim.vehicles[vehicle].sonar.ping_rate_max_hz)


def default_voxel_m(sim: Simulator) -> float:
    """Return the edge of the map's voxels that the scenario asks for."""
    return sim.scenario.survey.voxel_m if sim.scenario.survey is not None else VOXEL_M


def require_sonar(sim: Simulator, vehicle: str) -> None:
    """Raise ValueError unless the vehicle has a sonar to map with."""
    if not sim.vehicles[vehicle].sonars:
        raise ValueError(f"--map: vehicle '{vehicle}': carries no sonar")
