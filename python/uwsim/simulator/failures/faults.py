"""Faults: failures that begin on schedule, at random or on request, and end after their duration.

A fault acts through existing simulator parameters, such as a thruster's health or the ballast, overriding the values
from the scenario and the user; sensor readings are falsified where they are read (`distortion`). What a kind changes
is in uwsim.scenario.faults.
"""

from __future__ import annotations

import hashlib
import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from pydantic import FiniteFloat

from uwsim.base.agenda import NEVER, Agenda, Rank
from uwsim.base.arguments import plain
from uwsim.base.journal import Journal
from uwsim.base.saved_state import State
from uwsim.base.sealed import Sealed
from uwsim.base.sockets import blaming
from uwsim.instruments.distortion import Distortion
from uwsim.scenario.read.errors import Collected, ScenarioError
from uwsim.scenario.spec.fault import FAULTS, FaultModel, FaultyVehicle, Overlay
from uwsim.scenario.spec.scenario import Scenario
from uwsim.simulator.failures.events import EventLog
from uwsim.simulator.failures.fault import Fault, FaultState, checked_fault
from uwsim.simulator.network import Network
from uwsim.simulator.parameters.tree import find
from uwsim.simulator.tether import Tether
from uwsim.simulator.vehicle import Vehicle

FILL_S = 1.0  # interval at which the water from a leak is updated


class DistortionState(State):
    """The distortion of a sensor; see uwsim.instruments.distortion."""

    stuck: dict[str, list[float]] | None
    bias: FiniteFloat
    field: str | None


class FaultsState(State):
    """Saved faults, by name, and distorted sensors, by "vehicle/sensor"."""

    faults: dict[str, FaultState]
    sensors: dict[str, DistortionState]


class Faults(Sealed):
    """The faults of a simulator, `sim.faults`.

    sim.faults.inject("thruster", thruster="front_left", health=0.3, for_s=20.0)
    sim.faults.active        # names
    sim.faults.end("thruster")
    """

    def __init__(
        self,
        scenario: Scenario,
        vehicles: Mapping[str, Vehicle],
        tethers: Mapping[str, Tether],
        *,
        events: EventLog,
        journal: Journal,
        agenda: Agenda,
        apply: Callable[[], None],
        network: Network | None = None,
        has_channels: bool = True,
    ) -> None:
        """apply: applies `overlay` to the running simulation. network: the link's network, if there is a link.

        has_channels: whether commands may arrive over channels, which a link fault cuts off if there is no network.
        """
        self._vehicles = vehicles
        self._tethers = tethers
        self._events = events
        self._journal = journal
        self._apply = apply
        self._agenda = agenda
        self._network = network
        self._link_carries = has_channels or network is not None
        self._scenario = scenario
        self._faults: dict[str, Fault] = {}
        self.restart(scenario)

    def restart(self, scenario: Scenario) -> None:
        """Return to the start of a run of a scenario, possibly with a different seed."""
        self._scenario = scenario
        self._faults = {}
        found = Collected()
        for index, spec in enumerate(scenario.faults):
            with found.noted():
                try:
                    self._add(spec, 0)
                except ValueError as error:
                    raise ScenarioError(
                        f"{scenario.source_file.line_prefix('faults', index)}faults[{index}]: {error}"
                    ) from None
        found.raise_any()
        for vehicle in self._vehicles.values():
            for sensor in vehicle.sensors.values():
                sensor.distort(None)
        self._load_tethers()
        self._attend()

    def _attend(self) -> None:
        """Register with the agenda only while there are active or pending faults, so that other runs step faster."""
        self._agenda.remove(self)
        if self._faults:
            self._agenda.add(self, Rank.FAULT, self.act)

    def __repr__(self) -> str:
        return f"<Faults: {', '.join(self._faults) or 'none'}; active: {', '.join(self.active) or 'none'}>"

    @property
    def active(self) -> tuple[str, ...]:
        """The names of the active faults."""
        return tuple(name for name, fault in self._faults.items() if fault.is_active)

    def water_kg(self, vehicle: str) -> float:
        """Return the mass of water inside a vehicle [kg] as of the last update."""
        return sum(fault.water_kg for fault in self._faults.values() if fault.vehicle == vehicle)

    def link_is_down(self, vehicle: str) -> bool:
        """Return whether all messages between the station and a vehicle are blocked."""
        if not self._faults:  # asked for every message
            return False
        return any(f.is_active and f.vehicle == vehicle and f.spec.cuts_link for f in self._faults.values())

    def inject(self, kind: str, *, name: str | None = None, **figures: Any) -> str:
        """Start a fault now; return its name. See docs/guides/faults.md for kinds and parameters.

        Raises ValueError and changes nothing if the fault is invalid.
        """
        step_s = self._scenario.step_s
        given = {"kind": kind, "name": name, **figures}
        begins = {} if {"at_s", "rate_per_h"} & figures.keys() else {"at_s": self._agenda.tick * step_s}
        spec = checked_fault({**given, **begins})
        # in the journal's form, so that a replay has the same state
        spec = spec.model_copy(update={"name": spec.name or self._free_name(spec.kind)})
        if spec.at_s is not None and round(spec.at_s / step_s) < self._agenda.tick:
            raise ValueError(f"faults.inject: at_s = {spec.at_s} s: is in the past")
        fault = self._add(spec, self._agenda.tick)
        if fault.begin_tick <= self._agenda.tick:
            try:
                self._begin(fault, self._agenda.tick)
                self._apply()
            except ValueError:
                del self._faults[fault.name]
                raise
        self._attend()
        plain_figures = {key: plain(value, f"faults.inject: {key}") for key, value in figures.items()}
        self._journal.note("inject_fault", kind=kind, name=fault.name, **plain_figures)
        return fault.name

    def end(self, name: str) -> None:
        """End a fault permanently. Water that has leaked in remains. Raises ValueError for an unknown name."""
        if name not in self._faults:
            raise ValueError(f"faults.end: name = {name!r}: must be one of {', '.join(self._faults) or 'none'}")
        fault = self._faults[name]
        if fault.is_active:
            self._end(fault, self._agenda.tick)
            self._apply()
        fault.begin_tick = NEVER
        self._journal.note("end_fault", name=name)

    def overlay(self, scenario: Scenario) -> dict[str, Any]:
        """Return, by name, the parameter values with which faults override those of a scenario."""
        found = _Overlay(scenario)
        for fault in self._faults.values():
            if fault.is_active or fault.water_kg > 0:
                self._apply_one(fault.spec, found, fault.vehicle, scenario, fault.water_kg)
        return found

    def overlay_of(self, spec: FaultModel) -> dict[str, Any]:
        """Return what `overlay` would be by one fault alone: at its end, or soon after its beginning if it has none."""
        found, step_s = _Overlay(self._scenario), self._scenario.step_s
        water_kg = spec.water_kg_after(0.0, NEVER if spec.for_s is None else self._ticks(spec.for_s), step_s)
        if spec.water_kg_after(water_kg, NEVER, step_s) > water_kg and spec.for_s is None:  # it is never full
            water_kg = spec.water_kg_after(0.0, self._ticks(FILL_S), step_s)
        vehicle = spec.vehicle or next(iter(self._vehicles))
        self._apply_one(spec, found, vehicle, self._scenario, water_kg)
        return found

    def _apply_one(self, spec: FaultModel, overlay: Overlay, vehicle: str, scenario: Scenario, water_kg: float) -> None:
        with blaming(FAULTS.group, spec.kind, "apply"):
            spec.apply(overlay, self._faulty(vehicle, scenario), water_kg)

    def _faulty(self, vehicle: str, scenario: Scenario) -> FaultyVehicle:
        model = next(entry.model for entry in scenario.vehicles if entry.name == vehicle)
        its = self._vehicles[vehicle]
        return FaultyVehicle(vehicle, model, its.sensors, its.sonars, self._tethers)

    @property
    def due_tick(self) -> int:
        """The next tick at which a fault begins, ends or needs an update."""
        return min((self._due(fault) for fault in self._faults.values()), default=NEVER)

    def _due(self, fault: Fault) -> int:
        if fault.end_tick is None:
            return fault.begin_tick
        fill_tick = fault.filled_tick + self._ticks(FILL_S)
        return min(fault.end_tick, fill_tick) if self._water_kg(fault, fill_tick) > fault.water_kg else fault.end_tick

    def act(self, tick: int) -> None:
        """Begin, update and end the faults that are due."""
        for fault in self._faults.values():
            if self._due(fault) > tick:
                continue
            if fault.is_active:
                self._fill(fault, tick)
                if fault.end_tick is not None and fault.end_tick <= tick:
                    self._end(fault, tick)
            else:
                self._begin(fault, tick)
        self._apply()

    def save(self) -> dict[str, Any]:
        """Return, as JSON values, everything that future steps depend on."""
        stuck = {
            f"{vehicle.name}/{name}": asdict(sensor.distortion)
            for vehicle in self._vehicles.values()
            for name, sensor in vehicle.sensors.items()
            if sensor.distortion is not None
        }
        return {"faults": {name: fault.save() for name, fault in self._faults.items()}, "sensors": stuck}

    def restore(self, state: FaultsState) -> None:
        """Load a state returned by `save`; the caller applies the overlay. Raises ValueError."""
        self._faults = {}
        for name, saved in state.faults.items():
            fault = self._faults[name] = Fault.restored(name, saved)
            self._check(fault.spec, fault.vehicle)
        for vehicle in self._vehicles.values():
            for name, sensor in vehicle.sensors.items():
                distorted = state.sensors.get(f"{vehicle.name}/{name}")
                sensor.distort(None if distorted is None else Distortion(**dict(distorted)))
        self._load_tethers()
        self._attend()

    # Beginning and ending

    def _add(self, spec: FaultModel, tick: int) -> Fault:
        vehicle = spec.vehicle or next(iter(self._vehicles))
        self._check(spec, vehicle)
        name = spec.name or self._free_name(spec.kind)
        if name in self._faults:
            raise ValueError(f"name = {name!r}: is already in use")
        fault = self._faults[name] = Fault(name, spec, vehicle, 0)
        fault.begin_tick = self._next_begin(fault, tick)
        if spec.cuts_link and not self._link_carries:
            warnings.warn(
                f"fault '{name}': without a link in the scenario it does nothing here but to be an event",
                UserWarning,
                stacklevel=2,
            )
        return fault

    def _check(self, spec: FaultModel, vehicle: str) -> None:
        if vehicle not in self._vehicles:
            raise ValueError(f"vehicle = {vehicle!r}: must be one of {', '.join(self._vehicles)}")
        spec.check(self._faulty(vehicle, self._scenario))

    def _free_name(self, kind: str) -> str:
        names = [kind, *(f"{kind}_{number}" for number in range(2, len(self._faults) + 3))]
        return next(name for name in names if name not in self._faults)

    def _next_begin(self, fault: Fault, after_tick: int) -> int:
        """Return the tick at which a fault next begins: once, at at_s, or at random intervals (a Poisson process)."""
        if fault.spec.at_s is not None:
            return round(fault.spec.at_s / self._scenario.step_s) if fault.count == 0 else NEVER
        assert fault.spec.rate_per_h is not None
        interval_s = -math.log(self._draw(fault)) * 3600.0 / fault.spec.rate_per_h
        return after_tick + self._ticks(interval_s)

    def _draw(self, fault: Fault) -> float:
        """Return a random value in (0, 1) that depends only on seed, name and count (counter-based Philox 4 x 64)."""
        stream = int.from_bytes(hashlib.blake2b(f"fault/{fault.name}".encode(), digest_size=8).digest(), "little")
        key = np.array([self._scenario.seed, stream], np.uint64)
        counter = np.array([fault.count, 0, 0, 0], np.uint64)
        return 1.0 - float(np.random.Generator(np.random.Philox(key=key, counter=counter)).random())

    def _begin(self, fault: Fault, tick: int) -> None:
        spec = fault.spec
        drawn = {} if spec.rate_per_h is None else {"drawn": self._draw(fault)}
        fault.count += 1
        fault.end_tick = NEVER if spec.for_s is None else tick + self._ticks(spec.for_s)
        fault.began_tick = fault.filled_tick = tick
        spec.begin(self._faulty(fault.vehicle, self._scenario))
        self._load_tethers()
        self._cut_off(fault)
        figures = spec.model_dump(exclude={"name", "vehicle", "at_s", "rate_per_h"}, exclude_none=True)
        self._events.add(tick, fault.vehicle, "fault", fault=fault.name, **figures, **drawn)

    def _end(self, fault: Fault, tick: int) -> None:
        self._fill(fault, tick)
        fault.end_tick = None
        fault.begin_tick = self._next_begin(fault, tick)
        fault.spec.end(self._faulty(fault.vehicle, self._scenario))
        self._load_tethers()
        self._cut_off(fault)
        self._events.add(tick, fault.vehicle, "fault_ends", fault=fault.name)

    def _cut_off(self, fault: Fault) -> None:
        if self._network is not None and fault.spec.cuts_link:
            self._network.cut_off(fault.vehicle, self.link_is_down(fault.vehicle))  # another fault may still be active

    def _load_tethers(self) -> None:
        """Let each tether bear what active faults leave; saved states do not include it."""
        for name, tether in self._tethers.items():
            loads = (f.spec.tether_bears_n(name, f.vehicle) for f in self._faults.values() if f.is_active)
            tether.weaken(min(loads, default=math.inf))

    def _fill(self, fault: Fault, tick: int) -> None:
        """Update the mass of water that a fault has let in."""
        water_kg = self._water_kg(fault, tick)
        if water_kg > fault.water_kg:
            fault.water_kg, fault.filled_tick = water_kg, tick

    def _water_kg(self, fault: Fault, tick: int) -> float:
        return fault.spec.water_kg_after(fault.water_kg, tick - fault.filled_tick, self._scenario.step_s)

    def _ticks(self, duration_s: float) -> int:
        return max(1, min(round(duration_s / self._scenario.step_s), NEVER))


class _Overlay(dict[str, Any]):
    """Parameters changed by faults, by name; others are read from a scenario. Raises ValueError for unknown names."""

    def __init__(self, scenario: Scenario) -> None:
        super().__init__()
        self._scenario = scenario

    def __missing__(self, name: str) -> Any:
        node = find(self._scenario, name)
        if node is None:
            raise ValueError(f"{name}: is not a parameter")
        return node.value
