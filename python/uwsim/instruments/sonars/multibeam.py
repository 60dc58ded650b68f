"""A vehicle's multibeam sonars."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from types import MappingProxyType
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.arguments import number
from uwsim.base.journal import Journal
from uwsim.base.motion import Pose
from uwsim.base.sealed import Attached
from uwsim.mapping.ping_to_map import PingToMap


class ChainOf(Protocol):
    """Returns the chain from a multibeam's pings to a map; see uwsim.scenario.build.multibeam."""

    def __call__(
        self, model: _core.MultibeamModel, *, in_physics: bool, outlier_filter: bool | None, voxel_m: float | None
    ) -> PingToMap:
        """Return a chain without a filler."""


class Sonar(Attached):
    """A multibeam sonar, whose head faces forward and can be tilted.

    mode: "geometry" (one exact ray per beam) or "physics" (echoes with errors; see _core.PhysicsPing).
    """

    name: str
    model: _core.MultibeamModel
    mode: str
    _changed_by = MappingProxyType({"elevation_rad": "aim()", "target_elevation_rad": "aim()"})

    def __init__(
        self,
        simulation: _core.Simulation,
        vehicle: int,
        index: int,
        spec: _core.SonarSpec,
        journal: Journal,
        owner: str,
        chain_of: ChainOf,
        pose: Callable[[], Pose],
        *,
        water_column: bool = False,
        threads: int = 1,
    ) -> None:
        self._simulation = simulation
        self._threads = threads
        self._vehicle = vehicle
        self._index = index
        self._journal = journal
        self._owner = owner
        self._water_column = water_column
        self._chain_of, self._pose = chain_of, pose
        self._chain: PingToMap | None = None
        self._mapped_as: tuple[bool | None, float | None] = None, None
        self.name = spec.name
        self.change(spec)
        self._last: tuple[tuple[int, bool], _core.Ping] | None = None

    def change(self, spec: _core.SonarSpec) -> None:
        """Replace the model or mode. Simulator.parameters calls this."""
        in_physics_mode = self._simulation.in_physics_mode(self._vehicle, self._index)
        self.__dict__ |= {"model": spec.model, "mode": "physics" if in_physics_mode else "geometry"}
        self._chain = None

    @property
    def chain(self) -> PingToMap:
        """The processing chain from this sonar's pings to a map, as specified by the scenario's survey.

        Every map of its pings is made by this chain, or from topics whose echoes it has kept. It has no filler.
        """
        if self._chain is None:
            outlier_filter, voxel_m = self._mapped_as
            in_physics = self.mode == "physics"
            self._chain = self._chain_of(
                self.model, in_physics=in_physics, outlier_filter=outlier_filter, voxel_m=voxel_m
            )
        return self._chain

    def map_as(self, outlier_filter: bool | None, voxel_m: float | None) -> None:
        """Override the survey's outlier_filter and voxel_m in `chain`; None for the survey's own."""
        self._mapped_as, self._chain = (outlier_filter, voxel_m), None

    def __repr__(self) -> str:
        span_deg = math.degrees(self.model.field_of_view_rad)
        fan = f"{self.model.beams} beams over {span_deg:.0f} deg, {self.model.range_max_m:g} m"
        return f"<Sonar '{self.name}': {self.model.name}, {fan}, {self.mode} mode>"

    def aim(self, elevation_rad: float) -> None:
        """Set the elevation to which the head turns: positive up, 0 straight ahead. Raises ValueError beyond +-pi/2.

        The head turns as simulated time passes, at the model's tilt rate; `elevation_rad` is its current elevation.
        """
        angle = number(elevation_rad, "elevation_rad", "rad")
        self._simulation.aim(self._vehicle, self._index, angle)
        if self._journal.observers:
            self._journal.note("aim", vehicle=self._owner, elevation_rad=angle, sonar=self.name)

    @property
    def elevation_rad(self) -> float:
        """The head's current elevation, at which it pings."""
        return self._simulation.sonar_elevation_rad(self._vehicle, self._index)

    @property
    def target_elevation_rad(self) -> float:
        """The head's target elevation, as last passed to `aim`."""
        return self._simulation.sonar_target_elevation_rad(self._vehicle, self._index)

    @property
    def is_aimed(self) -> bool:
        """True once the head has reached its target elevation."""
        return self.elevation_rad == self.target_elevation_rad

    @property
    def ping_rate_max_hz(self) -> float:
        """The highest ping rate at which sound returns from the maximum range before the next ping: c / (2 range).

        c is the speed of sound at the head's current depth. Surveys stay within this rate; `ping` does not enforce it,
        since pinging takes no simulated time.
        """
        return self._simulation.sonar_ping_rate_max_hz(self._vehicle, self._index)

    def ping(self, *, water_column: bool | None = None) -> _core.Ping:
        """Ping once from the vehicle's current pose; see _core.Ping for the arrays. All pings at one time are equal.

        Surfaces above the water return no echo. A head above the water or under the terrain receives no echoes: no beam
        is valid, and all ranges are inf. A head inside an obstacle receives echoes from its walls. In physics mode the
        result is a _core.PhysicsPing, which has additional arrays. `OccupancyMap.insert` maps it.

        water_column: in physics mode, whether the ping contains the level of every range sample of every beam, as
        `water_column` (beams, samples) and `water_column_ranges_m` (samples,); by default, the scenario's
        `sonar.water_column` decides. It changes nothing else in the ping. Raises ValueError if True in geometry mode.
        """
        wanted = self._water_column if water_column is None else water_column
        key = self._simulation.version, wanted
        last = self._last
        return last[1] if last is not None and last[0] == key else self._keep(key, self._new_ping(wanted))

    def _keep(self, key: tuple[int, bool], ping: _core.Ping) -> _core.Ping:
        vars(ping).update(chain=self.chain, world_from_body=self._pose().world_from_body)
        self.__dict__["_last"] = key, ping  # faster than __setattr__, which checks names
        return ping

    def _new_ping(self, water_column: bool) -> _core.Ping:
        if self.mode == "physics":
            ping = self._simulation.acoustic_ping(self._vehicle, self._index, self._threads, water_column)
            return cast(_core.Ping, ping)
        if water_column:
            raise ValueError("water_column = True: is for `mode: physics` only")
        return self._simulation.ping(self._vehicle, self._index)

    def ping_batch(self, world_from_body: NDArray[np.float64], threads: int | None = None) -> _core.PingBatch:
        """Ping from many vehicle poses, (n, 4, 4) rigid transforms, without moving the vehicle.

        The result's arrays are (n, beams); see _core.PingBatch. The mode is always geometry, with the head at its
        current elevation. threads: defaults to all; results do not depend on it. Raises ValueError if a pose is not
        rigid.
        """
        return self._simulation.ping_batch(self._vehicle, self._index, world_from_body, threads)


def ping_together(simulation: _core.Simulation, sonars: Sequence[Sonar], threads: int) -> list[_core.Ping]:
    """Return the pings of several multibeams of a simulation; see `Simulator.ping`."""
    foreign = next((sonar for sonar in sonars if sonar._simulation is not simulation), None)
    if foreign is not None:
        raise ValueError(f"sonars: {foreign!r} is of another simulator")
    version = simulation.version
    keys = {sonar: (version, sonar._water_column) for sonar in sonars}
    due = [sonar for sonar, key in keys.items() if sonar._last is None or sonar._last[0] != key]
    heads = [(sonar._vehicle, sonar._index, sonar._water_column) for sonar in due]
    for sonar, ping in zip(due, simulation.pings_together(heads, threads), strict=True):
        sonar._keep(keys[sonar], cast(_core.Ping, ping))
    return [sonar.ping() for sonar in sonars]
