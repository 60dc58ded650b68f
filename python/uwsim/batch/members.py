"""The definitions from which batch members are built."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from uwsim import _core
from uwsim.batch.arguments import Changes
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.build.craft import ControlSettings
from uwsim.scenario.build.loose_bodies import object_specs
from uwsim.scenario.build.station import link_spec, tether_specs
from uwsim.scenario.build.vehicle import vehicle_control, vehicle_errors_at, vehicle_spec
from uwsim.scenario.build.water import surface_density_kg_m3
from uwsim.scenario.build.world import scenario_water, simulation_spec
from uwsim.scenario.spec.fault import FaultModel
from uwsim.simulator.parameters import Parameters
from uwsim.simulator.parameters.edits import edited
from uwsim.simulator.parameters.tree import Place


@dataclass(frozen=True, eq=False)
class Member:
    """A member's definition.

    original: the scenario with the member's seed and faults. changes: the member's parameters. scenario: `original`
    with `changes` applied.
    """

    original: Scenario
    scenario: Scenario
    water: _core.Water
    changes: Changes
    vehicles: Sequence[_core.VehicleSpec]
    spec: _core.MemberSpec

    @property
    def off(self) -> list[tuple[int, int]]:
        """The sensors that are off, as pairs of vehicle index and sensor index."""
        return [
            (index, place)
            for index, entry in enumerate(self.scenario.vehicles)
            for place, sensor in enumerate(entry.model.sensors.values())
            if not sensor.on
        ]

    @property
    def has_programs(self) -> bool:
        """Whether the member has any programs, that is, faults or a vehicle with a failsafe."""
        failsafes = (entry.failsafe or entry.model.failsafe for entry in self.scenario.vehicles)
        return bool(self.scenario.faults) or any(failsafes)


class Members:
    """Builds the specs for members of one scenario and world. Identical vehicles share specs.

    vehicles: the specs of the scenario's vehicles, without any member parameters.
    """

    def __init__(self, scenario: Scenario, world: _core.World) -> None:
        self._scenario = scenario
        self._world = world
        self._places: dict[tuple[str, ...], Sequence[Place]] = {}
        self.vehicles = [self._made(scenario, index) for index in range(len(scenario.vehicles))]
        self._objects = object_specs(scenario)
        self._tethers = list(tether_specs(scenario).values())
        self._latest: tuple[Changes, Sequence[FaultModel], Scenario, list[_core.VehicleSpec]] = {}, (), scenario, []

    def member(self, index: int, seed: int, changes: Changes, faults: Sequence[FaultModel]) -> Member:
        """Return the definition of the member with this index, seed, parameters and faults.

        Raises ValueError with the member's index.
        """
        try:
            original = self._scenario.model_copy(update={"seed": seed, "faults": tuple(faults)})
            scenario, vehicles = self._built(original, changes)
            water = scenario_water(scenario, self._world)
        except ValueError as error:
            raise ValueError(f"batch[{index}]: {error}") from None
        link = None if scenario.link is None else link_spec(scenario.link, scenario.station, self._world)
        spec = _core.MemberSpec(water, simulation_spec(scenario), vehicles, link, self._objects, self._tethers)
        return Member(original, scenario, water, changes, vehicles, spec)

    @cached_property
    def control(self) -> list[ControlSettings]:
        """The control settings of each vehicle, which no parameter affects."""
        entries = zip(self._scenario.vehicles, self.vehicles, strict=True)
        return [vehicle_control(self._scenario, entry.model, spec) for entry, spec in entries]

    def _built(self, original: Scenario, changes: Changes) -> tuple[Scenario, list[_core.VehicleSpec]]:
        """Return the scenario with these changes, and its vehicles. Consecutive identical members share them."""
        before, faults, latest, vehicles = self._latest
        same_types = [*map(type, changes.values())] == [*map(type, before.values())]  # True is equal to 1.0
        if vehicles and same_types and changes == before and original.faults == faults:
            return latest.model_copy(update={"seed": original.seed}), vehicles
        scenario = self._changed(original, changes)
        vehicles = [self._vehicle(scenario, k) for k in range(len(scenario.vehicles))]
        self._latest = dict(changes), original.faults, scenario, vehicles
        return scenario, vehicles

    def _changed(self, original: Scenario, changes: Changes) -> Scenario:
        """Return a copy of a scenario with the given parameter values.

        Most of the time goes into locating the parameters. Since their locations do not depend on the values, they are
        cached once values for these names have been accepted.
        """
        names = tuple(changes)
        if not names:
            return original
        are_numbers = all(type(value) in (int, float) for value in changes.values())
        places = self._places.get(names)
        if places is not None and are_numbers:
            try:
                return edited(original, dict(zip(places, changes.values(), strict=True)))
            except ScenarioError:
                pass  # reported below, with the parameter names
        parameters = Parameters(original, lambda _: None, lambda *_, **__: None, {})
        parameters.update(changes)
        if are_numbers:
            self._places[names] = parameters.places(names)
        return parameters.scenario

    def _vehicle(self, scenario: Scenario, index: int) -> _core.VehicleSpec:
        entry, first = scenario.vehicles[index], self._scenario.vehicles[index]
        same_trim = scenario.water == self._scenario.water or (
            entry.model.compressibility_1_pa is None
            and surface_density_kg_m3(scenario.water) == surface_density_kg_m3(self._scenario.water)
        )
        if same_trim and (entry is first or entry == first):
            return self.vehicles[index]
        return self._made(scenario, index)

    @staticmethod
    def _made(scenario: Scenario, index: int) -> _core.VehicleSpec:
        with vehicle_errors_at(scenario, index):
            return vehicle_spec(scenario, scenario.vehicles[index])
