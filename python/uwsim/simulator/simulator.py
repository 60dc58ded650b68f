"""Simulator, the main class: holds a scenario's world and vehicles, and advances them in fixed steps."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import Any, Self

import numpy as np

from uwsim import _core
from uwsim.base.agenda import Agenda
from uwsim.base.arguments import checked_threads, number
from uwsim.base.journal import Journal
from uwsim.base.named import Named
from uwsim.base.saved_state import SavedState
from uwsim.instruments.acoustics.pinger_sound import PingerSound
from uwsim.instruments.cameras import Camera
from uwsim.instruments.cameras.mounted import (
    SavedHeads,
    SavedLamps,
    camera_mounts,
    change_cameras,
    station_cameras,
    vehicle_cameras,
)
from uwsim.instruments.cameras.shared_scene import SharedScene
from uwsim.instruments.sample_stream import Deliveries
from uwsim.instruments.sonars.imaging import Acoustics
from uwsim.instruments.sonars.mounted import imaging_models, imaging_sonars
from uwsim.mapping.ping_to_map import PingToMap
from uwsim.scenario import AnyScenario, Scenario, VehicleEntry, VehicleModel, build_world, load
from uwsim.scenario.build.craft import ControlSettings
from uwsim.scenario.build.hull import hull_radius_m
from uwsim.scenario.build.loose_bodies import object_specs
from uwsim.scenario.build.measured_water import temperature_is_known
from uwsim.scenario.build.multibeam import ping_chain
from uwsim.scenario.build.station import add_tethers, carrier_index, dock_position, exit_position
from uwsim.scenario.build.vehicle import vehicle_control, vehicle_errors_at, vehicle_spec
from uwsim.scenario.build.wind import ShortWavesWarning, short_wave_warning
from uwsim.scenario.build.world import beyond_terrain, fill_with_water, scenario_water, simulation_spec
from uwsim.scenario.fingerprint import build_fingerprint, scenario_fingerprint, warn_of_other_build
from uwsim.scenario.read.errors import Collected
from uwsim.simulator.arm import sensed
from uwsim.simulator.docking import Dock
from uwsim.simulator.failures import EventLog, Faults, Reactions
from uwsim.simulator.lockstep import Lockstep
from uwsim.simulator.logged import Logged
from uwsim.simulator.loose_body import LooseBody, loose_bodies
from uwsim.simulator.network import Network
from uwsim.simulator.onboard_navigation import Estimates, new_navigator
from uwsim.simulator.parameters import Parameters
from uwsim.simulator.properties import SimulatorProperties
from uwsim.simulator.tether import Tether, tethers_of
from uwsim.simulator.vehicle import Vehicle

STEP_TOLERANCE = 1e-6  # relative amount by which a duration may differ from a whole number of steps


class Simulator(SimulatorProperties):
    """A running scenario.

    scenario: a packaged scenario's name ("lake"), the path of a YAML file or its content, or a Scenario. seed,
    sonar_model (for all vehicles: 1 to 4, a packaged model's name or a path), sonar_frequency_hz (for a model with
    several), vehicle_model (of the first vehicle: a packaged model's name, a path or a VehicleModel), mission_time_s,
    link (a modem's name or path): override the scenario's values. threads: maximum number of threads,
    by default one per core; results do not depend on it. Raises ScenarioError, with file, line, key, value and rule.

    Reading, pinging and telemetry do not advance time; repeated at the same time, they return the same sample.
    Concurrent calls are serialised. cameras: the station's. objects: loose bodies. tethers: by
    the name of the vehicle or object at their second end. events: faults, alarms and failsafe reactions so far.
    """

    _copied_by = "create another one from sim.scenario, and transfer the state with save_state() and restore_state()"
    _has_channels = True  # whether commands may arrive over channels, which a link fault cuts off

    scene: _core.RayScene
    agenda: Agenda
    journal: Journal
    lockstep: Lockstep
    cameras: Named[Camera]
    objects: Named[LooseBody]
    tethers: Named[Tether]
    events: EventLog
    faults: Faults
    logged: Logged
    _changed_by = MappingProxyType(
        {
            "optics": "set_optics()",
            "parameters": "parameters[name] = value or parameters.update()",
            "time_s": "step() or advance()",
            "time_ns": "step() or advance()",
            "seed": "reset(seed=...)",
            "step_s": "the scenario's step_s",
            "scenario": "Simulator(scenario)",
            "threads": "Simulator(scenario, threads=...)",
            "link": "Simulator(scenario, link=...)",
            "world": "the scenario",
        }
    )
    _meant = MappingProxyType(
        {
            "save": "save_state()",
            "load": "restore_state()",
            "restore": "restore_state()",
            "state": "save_state(), or rov.pose and rov.velocity",
            "run": "advance()",
            "position": "rov.pose.position_world_m",
            **dict.fromkeys(("roll", "pitch", "orientation"), "rov.pose.orientation_xyzw"),
            **dict.fromkeys(("yaw", "heading"), "rov.pose.yaw_rad"),
            "close": "del sim: there is nothing to close",
        }
    )

    def __init__(
        self,
        scenario: AnyScenario = "lake",
        *,
        seed: int | None = None,
        sonar_model: int | str | Path | None = None,
        sonar_frequency_hz: float | None = None,
        vehicle_model: str | Path | VehicleModel | None = None,
        mission_time_s: float | None = None,
        link: str | Path | None = None,
        threads: int | None = None,
    ) -> None:
        own = load(scenario).with_changes(
            seed=seed, mission_time_s=mission_time_s, sonar_model=sonar_model, sonar_frequency_hz=sonar_frequency_hz,
            vehicle_model=vehicle_model, modem=link,
        )  # fmt: skip
        checked = checked_threads(threads)
        world = build_world(own)
        scene = _core.RayScene(world)
        self._assemble(own, own, checked, world, scene, _core.Simulation(world, scene, simulation_spec(own)))

    def _assemble(
        self,
        scenario: Scenario,
        running: Scenario,
        threads: int,
        world: _core.World,
        scene: _core.RayScene,
        core: _core.Simulation,
        like: SharedScene | None = None,
    ) -> None:
        """Assemble the simulator around a native simulation. Raises ScenarioError.

        running: the scenario with changed parameters, from which the native simulation was built. like: cameras that
        see the same surfaces.
        """
        self._scenario = scenario
        self._digest: tuple[Scenario, str] | None = None
        self.threads = threads
        self.events = EventLog(scenario.step_s)
        self.logged = Logged()
        self._world = world
        self._fixed_world = _core.FixedWorld(world)
        self.scene = scene
        self._core = core
        self.agenda = Agenda(partial(getattr, self._core, "tick"))
        self.journal = Journal(self.agenda)
        self.lockstep = Lockstep(self._core)
        self._specs: list[_core.VehicleSpec] = []
        self._shared_scene = SharedScene(running, world, scene, core, threads, self.journal, like)
        self.cameras = Named(station_cameras(self.scenario.station, self._shared_scene), "cameras")
        dock = self._dock = self._made_dock()
        self.tethers = Named(tethers_of(core, scenario), "tethers")
        vehicles, found = dict[str, Vehicle](), Collected()
        for index, entry in enumerate(running.vehicles):
            with found.noted(), vehicle_errors_at(running, index):
                vehicles[entry.name] = self._vehicle(index, entry, dock)
        found.raise_any()
        self.vehicles = Named(vehicles, "vehicles")
        Deliveries(self.agenda, [each.source for rov in vehicles.values() for each in rov.sensors.values()])
        self._add_objects()
        self._add_tethers()
        self.objects = Named(loose_bodies(core, running, self.journal, self.tethers), "objects")
        for index, rov in enumerate(vehicles.values()):
            if (text := short_wave_warning(running, index, world.water, rov.control.net_buoyancy_n)) is not None:
                warnings.warn(text, ShortWavesWarning, stacklevel=3)
        self._link = self._joined()
        lamps = {f"{name}.lamps.{lamp.name}.on": lamp for name, rov in vehicles.items() for lamp in rov.lamps.values()}
        self.faults = Faults(
            self.scenario, vehicles, self.tethers, events=self.events, journal=self.journal, agenda=self.agenda,
            apply=lambda: self.parameters.reapply(), network=self._link, has_channels=self._has_channels,
        )  # fmt: skip
        self._parameters = Parameters(self.scenario, self._change, self.journal.note, lamps, self.faults.overlay)
        self._reactions = Reactions(self.faults)
        self._reactions.add_failsafes(
            self.scenario, vehicles, dock=dock, network=self._link, events=self.events, agenda=self.agenda
        )
        self._estimates = Estimates({name: rov.navigation for name, rov in vehicles.items()})
        self._saved = SavedState(
            self._core,
            before={"programs": self._reactions, "parameters": self._parameters},  # faults apply on top of parameters
            after={
                "lamps": SavedLamps({name: rov.lamps for name, rov in vehicles.items()}),
                "cameras": SavedHeads(self._shared_scene.heads),
                "events": self.events,
                "estimates": self._estimates,
            },
            resume=self._resume_vehicles,
        )

    def _vehicle(self, index: int, entry: VehicleEntry, dock: Dock) -> Vehicle:
        spec, control = self._added(index, entry)
        self._specs.append(spec)
        dock.hull_radii_m.append(hull_radius_m(entry.model))
        return Vehicle(
            self._core,
            index,
            spec,
            dock=dock,
            cameras=vehicle_cameras(entry, index, self._shared_scene),
            lamps=self._shared_scene.lamps[index],
            imaging_sonars=imaging_sonars(self, entry, self._imaging_models(index, entry)),
            journal=self.journal,
            mounts=entry.model.sensors,
            arrays=entry.model.hydrophones,
            droppers=entry.droppers,
            objects={body.name: body for body in self.scenario.objects},
            sound=PingerSound(self.scenario.pingers, self.scenario.sound, lambda: self.world),
            seed=lambda: self.seed,
            chain_of=partial(self._chain_of, index),
            water_column=entry.sonar.water_column,
            threads=self.threads,
            step_s=self.step_s,
            navigate=lambda rov, start: new_navigator(rov, start, self.world.water),
            control=control,
            beyond_terrain=lambda *place_m: beyond_terrain(self._world, self.scenario, *place_m),
            temperature_is_known=lambda: temperature_is_known(self.parameters.scenario.water),
            tether=self.tethers.get(entry.name),
            joints=sensed(entry.model.arm or {}, entry.name, self.step_s, lambda: self.seed),
        )

    def _chain_of(self, index: int, model: _core.MultibeamModel, **options: Any) -> PingToMap:
        """Return the chain from a multibeam's pings to a map, with the current parameters; see ping_chain."""
        scenario = self.parameters.scenario
        return ping_chain(scenario, scenario.vehicles[index].model, model, **options)

    def _imaging_models(self, index: int, entry: VehicleEntry) -> Mapping[str, Acoustics]:
        """Return the models of a vehicle's imaging sonars. Raises ValueError if one is invalid."""
        return imaging_models(self, entry)

    def _joined(self) -> Network | None:
        """Add the link to the native simulation."""
        return Network.of(self._core, self.scenario, self.world, self.journal)

    def _added(self, index: int, entry: VehicleEntry) -> tuple[_core.VehicleSpec, ControlSettings]:
        """Add a vehicle to the native simulation; return its spec. Raises ValueError."""
        spec = vehicle_spec(self.scenario, entry)
        self._core.add_vehicle(spec)
        return spec, vehicle_control(self.scenario, entry.model, spec)

    def _add_objects(self) -> None:
        """Add the loose bodies to the native simulation. Raises ScenarioError."""
        for index, spec in enumerate(object_specs(self.scenario)):
            with self.scenario.source_file.errors_at("objects", index):
                self._core.add_object(spec)

    def _add_tethers(self) -> None:
        """Add the tethers to the native simulation. Raises ScenarioError."""
        add_tethers(self.scenario, self._core)

    def _made_dock(self) -> Dock:
        station = self.scenario.station
        return Dock(
            self._core,
            self.scene,
            dock_position(station),
            exit_position(station),
            float(np.radians(station.yaw_deg)),
            carrier_index(self.scenario),
        )

    def step(self, n: int = 1) -> None:
        """Advance by n fixed steps. Raises ValueError if n is negative or a vehicle's motion diverges."""
        if not (type(n) is int or isinstance(n, np.integer)) or not 0 <= n < 2**63:
            raise ValueError(f"n = {n!r} steps: must be a whole number, not negative")
        if n:
            for vehicle in self.vehicles.values():
                vehicle.warn_if_docked()
        for steps in (int(n),) if self.agenda.is_empty else self.agenda.parts(int(n)):
            self.lockstep.advance(steps)

    def advance(self, duration_s: float) -> None:
        """Advance by a duration. Raises ValueError unless it is a whole number of steps."""
        steps = number(duration_s, "duration_s", "s") / self.step_s
        if not np.isfinite(steps) or steps < 0:
            raise ValueError(f"duration_s = {duration_s} s: must be finite and not negative")
        if abs(steps - round(steps)) > STEP_TOLERANCE * max(1.0, steps):
            rule = f"must be a whole number of steps of {self.step_s:g} s (the scenario's step_s)"
            nearest = f"advance({round(steps) * self.step_s:.6g}), or wait({duration_s:.6g}), which rounds"
            raise ValueError(f"duration_s = {duration_s} s: {rule}; take {nearest}")
        self.step(round(steps))

    def wait(self, duration_s: float) -> None:
        """Advance by a duration, rounded to a whole number of steps, at least one. Missions use this as their clock.

        Raises ValueError.
        """
        steps = number(duration_s, "duration_s", "s") / self.step_s
        if not 0.0 <= steps < 2**53:
            raise ValueError(f"duration_s = {duration_s} s: must be finite and not negative")
        self.step(max(1, round(steps)) if steps else 0)

    def reset(self, seed: int | None = None) -> None:
        """Restart the run, as if with a new Simulator of this scenario; by default with the same seed.

        Vehicles, sensors and sonars remain the same objects; vehicles return to their starting poses, lamps and
        parameters to their values in the scenario. `version` keeps counting. Raises ValueError, changing nothing.
        """
        scenario = self.scenario.with_changes(seed=seed)
        self._reactions.restart(scenario)
        self.parameters.restore({})
        if scenario.seed != self.seed:
            fill_with_water(self._world, scenario)
            self._fixed_world = _core.FixedWorld(self._world)
        self._core.restart(self._world, simulation_spec(scenario))
        self.events.restore([])
        self._shared_scene.restart(scenario)
        self._scenario = scenario
        self.parameters.restart(scenario)
        self._resume_vehicles()
        self._estimates.restore({})
        self.agenda.jump()
        self.journal.note("reset", seed=scenario.seed)

    def log(self, topic: str, values: Mapping[str, Any]) -> None:
        """Send values of your own: of `sim.log("/size", {"length_m": 1.2})`, the topic is /size/length_m.

        Numbers, bools and texts, by name. Recorders and servers offer the topics that were logged before they opened.
        While a LiveSimulator runs, call this in `live.read`. Values are not part of the state, and a replay does not
        repeat them. Raises ValueError.
        """
        self.logged.log(topic, values)

    def save_state(self) -> bytes:
        """Save everything that future results depend on, except the scenario and the seed.

        This includes motion, commands, all stop, clocks, sensor states, lamps, camera pan and tilt, and changed
        parameters. A Simulator of the same scenario, seed and build that restores this state produces the same poses,
        samples and pictures to the last bit. The states of missions and maps are not included.
        """
        return self._saved.save(self._origin)

    def restore_state(self, state: bytes) -> None:
        """Continue from a state returned by `save_state`.

        Raises ValueError, changing nothing, if it is damaged or of another scenario; warns if another build saved it.
        """
        if not isinstance(state, bytes):
            raise ValueError(f"state is {type(state).__name__}: must be bytes returned by save_state")
        self._saved.restore(state, self._origin)
        self.agenda.jump()
        self.journal.note("restore_state", state=state)
        warn_of_other_build("the saved state", _core.saved_build(state))

    def take_over(self, other: Simulator) -> None:
        """Continue from the state of a simulator of another scenario, whose world may differ.

        Raises ValueError, changing nothing, unless both have the same step, seed, vehicles and parts aboard, by name.
        """
        self.restore_state(other._saved.save(self._origin))

    @property
    def _origin(self) -> tuple[str, str]:
        if self._digest is None or self._digest[0] is not self._scenario:  # it takes longer than saving the state
            self._digest = self._scenario, scenario_fingerprint(self._scenario)
        return self._digest[1], build_fingerprint()

    def _resume_vehicles(self) -> None:
        """After a jump in time, end all sample streams and infer from the actuators which vehicles are driven."""
        for rov in self.vehicles.values():
            commands = [*rov.effort, *rov.fins.values(), *(thruster.command for thruster in rov.thrusters.values())]
            rov.helm.is_driven = any(commands)
            for sensor in rov.sensors.values():
                sensor.end_streams()

    def _change(self, scenario: Scenario) -> None:
        """Switch to a scenario that differs only in parameters. Raises ValueError, changing nothing."""
        for rov in self.vehicles.values():
            rov.navigation.update()
        before = self.parameters.scenario
        other_water = scenario.water != before.water
        water = scenario_water(scenario, self._world) if other_water else self._world.water
        specs = list(self._specs)
        for index, (entry, old) in enumerate(zip(scenario.vehicles, before.vehicles, strict=True)):
            if other_water or entry != old:
                with vehicle_errors_at(scenario, index):
                    specs[index] = vehicle_spec(scenario, entry)
        sonars = [
            imaging_models(self, entry) if entry.model.imaging_sonars != old.model.imaging_sonars else {}
            for entry, old in zip(scenario.vehicles, before.vehicles, strict=True)
        ]
        if scenario.model_copy(update={"optics": before.optics}) != before:
            self._core.change(water, simulation_spec(scenario), specs)
        # Nothing below can fail.
        self._specs = specs
        if other_water:
            self._world.water = water
            self._fixed_world = _core.FixedWorld(self._world)
        self._shared_scene.change(scenario)
        change_cameras(self.cameras, scenario.station.cameras)
        for index, (entry, rov) in enumerate(zip(scenario.vehicles, self.vehicles.values(), strict=True)):
            self._dock.hull_radii_m[index] = hull_radius_m(entry.model)
            change_cameras(rov.cameras, camera_mounts(entry.model))
            rov.change(entry, specs[index], sonars[index])

    def __repr__(self) -> str:
        vehicles = ", ".join(self.vehicles)
        return f"<Simulator '{self.scenario.name}', seed {self.seed}, at {self.time_s:.3f} s, with {vehicles}>"

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Do nothing: the world is freed along with the object."""
