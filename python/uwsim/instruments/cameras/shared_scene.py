"""The state shared by all of a simulator's cameras: the scene, its light, and the current poses."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.journal import Journal
from uwsim.instruments.cameras.lamp import Lamp, station_lights
from uwsim.instruments.cameras.pan_tilt import PanTiltHead
from uwsim.scenario import Scenario, vehicle_hull
from uwsim.scenario.build.camera import camera_scene
from uwsim.scenario.spec.optics import Optics


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The scene's variable state at one time.

    positions_m (n, 3), orientations_xyzw (n, 4): pose of each vehicle, then of each object, then of what is attached to
    them, see SharedScene.attached_surfaces. velocities_body (m, 6): of each vehicle and object. lamps: the lamps that
    are on. aims_rad: pan and tilt of each motorised camera, by name.
    """

    time_ns: int
    positions_m: Floats
    orientations_xyzw: Floats
    velocities_body: Floats
    lamps: list[_core.SpotLamp]
    optics: Optics
    aims_rad: Mapping[str, tuple[float, float]]


@dataclass(eq=False)
class _Native:
    """The native scene, built when the first picture is taken."""

    scenario: Scenario
    world: _core.World
    rays: _core.RayScene
    like: _Native | None = None

    @cached_property
    def core(self) -> _core.CameraScene:
        if self.like is not None and _same_hulls(self.scenario, self.like.scenario):
            return self.like.core.with_water(self.world.water, self.scenario.seed)
        return camera_scene(self.scenario, self.world, self.rays)

    def again(self, scenario: Scenario, world: _core.World, rays: _core.RayScene) -> _Native:
        """Return the native scene of another variant of the scenario, which shares the first scene's surfaces."""
        return _Native(scenario, world, rays, self.like or self)


class SharedScene:
    """The scene that a simulator's cameras share.

    optics: water, sun and wind; may be replaced. lamps: for each vehicle, its lamps, keyed by switch name. heads: the
    cameras' motors, keyed by camera name. fixed_lights: the station's lamps that are on. The native scene is built for
    the first picture, so that simulators that take no pictures avoid its cost.
    """

    def __init__(
        self, scenario: Scenario, world: _core.World, rays: _core.RayScene, simulation: _core.Simulation, threads: int,
        journal: Journal, like: SharedScene | None = None,
    ) -> None:  # fmt: skip
        """like: another scene of the same world, with which this scene shares as much as possible."""
        self.journal = journal
        self.optics: Optics = scenario.optics
        self.threads = threads
        self.lamps: list[dict[str, Lamp]] = [
            {name: Lamp(name, spec) for name, spec in vehicle.model.lamps.items()} for vehicle in scenario.vehicles
        ]
        self.heads: dict[str, PanTiltHead] = {}
        self.fixed_lights = station_lights(scenario.station)
        self._scenario = scenario
        self._world = world
        self._rays = rays
        self._simulation = simulation
        self._native: _Native = (
            _Native(scenario, world, rays) if like is None else like._native.again(scenario, world, rays)
        )

    @property
    def core(self) -> _core.CameraScene:
        """The native scene: the world with its materials, plus the vehicle hulls.

        Raises ScenarioError if it cannot be built.
        """
        return self._native.core

    @property
    def has_cover(self) -> bool:
        """True if the scenario has cover or life, so that frames have pieces."""
        return bool(self._scenario.cover or self._scenario.life)

    def kept(self) -> SharedScene:
        """Return a copy that keeps the current materials, hulls and water, regardless of later changes."""
        return copy(self)

    def restart(self, scenario: Scenario) -> None:
        """Restart with a scenario that differs from the first only in its seed; lamps and light are reset."""
        if scenario.seed != self._scenario.seed:
            self._native = self._native.again(scenario, self._world, self._rays)
        self._scenario = scenario
        self.optics = scenario.optics
        for switches in self.lamps:
            for lamp in switches.values():
                lamp.set_silently(lamp.spec.on)
        for head in self.heads.values():
            head.restart()

    def change(self, scenario: Scenario) -> None:
        """Switch to a scenario that differs only in its parameters."""
        before = self._scenario
        if scenario.water != before.water or not _same_hulls(scenario, before):
            self._native = self._native.again(scenario, self._world, self._rays)
        self._scenario = scenario
        self.optics = scenario.optics
        self.fixed_lights = station_lights(scenario.station)
        for switches, vehicle in zip(self.lamps, scenario.vehicles, strict=True):
            for name, lamp in switches.items():
                lamp.change(vehicle.model.lamps[name])

    @property
    def time_ns(self) -> int:
        """Simulated time since the start in nanoseconds."""
        return self._simulation.time_ns

    def ground_m(self, position_m: Floats) -> float:
        """Return the terrain height z at a position (3,), whose own z is ignored; -inf outside the terrain."""
        height = float(self._world.height_at(position_m[None, :2])[0])
        return height if np.isfinite(height) else -np.inf

    def attached_surfaces(self) -> Floats:
        """Return where links of arms and tubes of tethers are, (n, 7): position [m] and quaternion x, y, z, w."""
        return self._simulation.attached_surfaces()

    def vehicle_pose(self, index: int) -> tuple[Floats, Floats]:
        """Return a vehicle's current position (3,) and orientation x, y, z, w (4,)."""
        state = self._simulation.state(index)
        return state.position_world_m, state.orientation_xyzw

    def snapshot(self, *, with_lamps: bool) -> Snapshot:
        """Return the current state, which is consistent even if other threads step the simulation meanwhile."""
        while True:
            version = self._simulation.version
            states = [self._simulation.state(k) for k in range(len(self.lamps))]
            states += [self._simulation.object_state(k) for k in range(len(self._scenario.objects))]
            attached = self.attached_surfaces()
            time_ns = self._simulation.time_ns
            if self._simulation.version == version:
                break
        positions = np.vstack([*(state.position_world_m for state in states), attached[:, :3]])
        orientations = np.vstack([*(state.orientation_xyzw for state in states), attached[:, 3:]])
        lamps = [
            light
            for position, orientation, switches in zip(positions, orientations, self.lamps, strict=False)
            for lamp in switches.values()
            if with_lamps and lamp.on
            for light in lamp.lights(position, orientation)
        ]
        lamps += self.fixed_lights if with_lamps else []
        aims = {name: head.angles_rad(time_ns) for name, head in self.heads.items()}
        velocities = np.array([state.velocity_body for state in states])
        return Snapshot(time_ns, positions, orientations, velocities, lamps, self.optics, aims)


def _same_hulls(one: Scenario, other: Scenario) -> bool:
    """Return whether all vehicles have the same hulls and arms in two variants of a scenario."""
    return all(
        a.model is b.model
        or (a.model.arm == b.model.arm and np.array_equal(vehicle_hull(a.model)[0], vehicle_hull(b.model)[0]))
        for a, b in zip(one.vehicles, other.vehicles, strict=True)
    )
