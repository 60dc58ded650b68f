"""The part of uwsim.Simulator that exposes its scenario, its world and its clock."""

from __future__ import annotations

from typing import Unpack

import numpy as np
from numpy.typing import NDArray

from uwsim import _core as native
from uwsim.base.named import Named
from uwsim.base.sealed import Attached
from uwsim.instruments.sonars.mounted import Surroundings
from uwsim.instruments.sonars.multibeam import Sonar, ping_together
from uwsim.scenario import Scenario
from uwsim.scenario.build.multibeam import backscatter_by_label, bottom_material, label_names
from uwsim.scenario.build.station import carrier_index
from uwsim.scenario.spec.optics import Optics, OpticsChanges
from uwsim.simulator.network import Network
from uwsim.simulator.parameters import Parameters
from uwsim.simulator.vehicle import Vehicle


class SimulatorProperties(Attached):
    """See uwsim.Simulator."""

    threads: int
    vehicles: Named[Vehicle]
    _core: native.Simulation
    _scenario: Scenario
    _parameters: Parameters
    _fixed_world: native.FixedWorld
    _link: Network | None

    @property
    def scenario(self) -> Scenario:
        """The scenario, without changes made through `parameters`; after `reset(seed)`, with that seed."""
        return self._scenario

    @property
    def parameters(self) -> Parameters:
        """The parameters that may be changed during a run, by name, such as "rov.drag.linear.surge"."""
        return self._parameters

    @property
    def world(self) -> native.FixedWorld:
        """The current terrain, obstacles and water; read-only."""
        return self._fixed_world

    def attach_tape(self, tape: native.Tape) -> None:
        """Let the simulation write a tape at the end of each step at which it is due, until detached or reset."""
        self._core.attach_tape(tape)

    def detach_tape(self, tape: native.Tape) -> None:
        """Stop writing a tape."""
        self._core.detach_tape(tape)

    def take_rows(
        self, tape: native.Tape, track: int
    ) -> tuple[NDArray[np.uint64], NDArray[np.uint64], NDArray[np.float64], NDArray[np.bool_]]:
        """Return the rows of a tape's track since the last call: see `Rows` of uwsim.channels.taped."""
        return self._core.take_rows(tape, track)

    @property
    def link(self) -> Network | None:
        """The link between station and vehicles, or None if messages are delivered immediately."""
        return self._link

    @property
    def rov(self) -> Vehicle:
        """The scenario's first vehicle."""
        return next(iter(self.vehicles.values()))

    @property
    def optics(self) -> Optics:
        """The optical properties used by cameras."""
        return self.parameters.scenario.optics

    def set_optics(self, **changes: Unpack[OpticsChanges]) -> None:
        """Change optical properties, such as jerlov="5C" or sun_elevation_deg=2. Raises ValueError."""
        self.parameters.update({f"optics.{name}": value for name, value in changes.items()})

    @property
    def strengths_db(self) -> Named[float]:
        """The backscatter strength of each surface for imaging sonars, keyed by the names in label_names."""
        strengths = [surface.strength_db for surface in backscatter_by_label(self.scenario)]
        found = dict(zip(self.label_names, strengths, strict=True))
        return Named(found, "strengths_db", "the sonar model's strengths_db")

    @property
    def materials(self) -> Named[native.BottomMaterial]:
        """How each surface scatters and reflects sound, keyed by the names in label_names."""
        found = dict(zip(self.label_names, map(bottom_material, backscatter_by_label(self.scenario)), strict=True))
        return Named(found, "materials", "the scenario's ground and materials")

    @property
    def label_names(self) -> list[str]:
        """The names of the labels that pings and rays return: World.label_names, followed by those of the vehicles."""
        return label_names(self.scenario)

    def link_surfaces(self) -> NDArray[np.float64]:
        """Return where the links of arms are that have a shape, (n, 7): position [m] and quaternion x, y, z, w."""
        return self._core.link_surfaces()

    def around(self, vehicle: str | None = None) -> Surroundings:
        """Return the current surroundings of a sonar: the world and all vehicles except the sonar's carrier.

        For imaging sonars and depth maps from arbitrary poses. `scene` has no vehicles. Raises ValueError.
        """
        names = list(self.vehicles)
        if vehicle is not None and vehicle not in names:
            raise ValueError(f"vehicle = {vehicle!r}: must be one of {', '.join(names)}")
        scene = self._core.scene_around(None if vehicle is None else names.index(vehicle))
        return Surroundings(scene, self.world, self.strengths_db, self.seed, self.threads, self.time_ns, self.materials)

    def ping(self, *sonars: Sonar) -> list[native.Ping]:
        """Ping with several multibeams at once, on all threads; return what `ping()` of each returns, in their order.

        Later calls of `ping()` at the same time return these pings. Raises ValueError for another simulator's sonar.
        """
        return ping_together(self._core, sonars, self.threads)

    @property
    def seed(self) -> int:
        """The seed from which all random draws are derived."""
        return self.scenario.seed

    @property
    def step_s(self) -> float:
        """The fixed step size in seconds."""
        return self.scenario.step_s

    @property
    def tick(self) -> int:
        """Number of steps since the start."""
        return self._core.tick

    @property
    def version(self) -> int:
        """A counter that changes whenever observations may: with time, vehicle poses and sonar elevations."""
        return self._core.version

    @property
    def time_ns(self) -> int:
        """Simulated time since the start, in nanoseconds."""
        return self._core.time_ns

    @property
    def time_s(self) -> float:
        """Simulated time since the start, in seconds."""
        return self._core.time_ns * 1e-9

    @property
    def station_world_m(self) -> NDArray[np.float64]:
        """The station's position (3,) now, which changes if a vehicle carries it."""
        carrier = carrier_index(self.scenario)
        position_m = np.asarray(self.scenario.station.position_m, np.float64)
        if carrier is None:
            return position_m
        world_from_body = self._core.state(carrier).world_from_body
        return np.asarray(world_from_body[:3, :3] @ position_m + world_from_body[:3, 3])
