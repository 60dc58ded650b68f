"""What each member of a batch is built from."""

from __future__ import annotations

from collections.abc import Sequence

from uwsim import _core
from uwsim.batch.arguments import Changes
from uwsim.parameters import Parameters
from uwsim.parameters.edits import edited
from uwsim.parameters.tree import Place
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.build.link import link_spec
from uwsim.scenario.build.simulation import simulation_spec
from uwsim.scenario.build.vehicle import vehicle_errors_at, vehicle_spec
from uwsim.scenario.build.water import surface_density_kg_m3
from uwsim.scenario.build.world import scenario_water

SEED: Place = ("seed",)


class Members:
    """Makes the specs of members of one scenario and world, which share the vehicles that are the same.

    vehicles: the scenario's own, without a member's parameters.
    """

    def __init__(self, scenario: Scenario, world: _core.World) -> None:
        _require_no_programs(scenario)
        self._scenario = scenario
        self._world = world
        self._places: dict[tuple[str, ...], Sequence[Place]] = {}
        self.vehicles = [self._made(scenario, index) for index in range(len(scenario.vehicles))]

    def member(self, index: int, seed: int, changes: Changes) -> _core.MemberSpec:
        """Return what the member of a place, seed and parameters is built from. Raises ValueError that names it."""
        try:
            scenario = self._changed(seed, changes)
            vehicles = [self._vehicle(scenario, k) for k in range(len(scenario.vehicles))]
            water = scenario_water(scenario, self._world)
        except ValueError as error:
            raise ValueError(f"batch[{index}]: {error}") from None
        link = None if scenario.link is None else link_spec(scenario.link, scenario.station)
        return _core.MemberSpec(water, simulation_spec(scenario), vehicles, link)

    def _changed(self, seed: int, changes: Changes) -> Scenario:
        """Return the scenario with a seed and parameters.

        Finding the places of parameters takes most of the time, so they are kept when numbers of these names have been
        accepted: what has an effect does not depend on numbers.
        """
        names = tuple(changes)
        if not names:
            return self._scenario.with_changes(seed=seed)
        are_numbers = all(type(value) in (int, float) for value in changes.values())
        places = self._places.get(names)
        if places is not None and are_numbers:
            try:
                return edited(self._scenario, {SEED: seed, **dict(zip(places, changes.values(), strict=True))})
            except ScenarioError:
                pass  # said below, by the parameters' names
        parameters = Parameters(self._scenario.with_changes(seed=seed), lambda _: None, lambda *_, **__: None, {})
        parameters.update(changes)
        _require_no_programs(parameters.scenario)
        if are_numbers:
            self._places[names] = parameters.places(names)
        return parameters.scenario

    def _vehicle(self, scenario: Scenario, index: int) -> _core.VehicleSpec:
        same_trim = surface_density_kg_m3(scenario.water) == surface_density_kg_m3(self._scenario.water)
        entry, first = scenario.vehicles[index], self._scenario.vehicles[index]
        if same_trim and (entry is first or entry == first):
            return self.vehicles[index]
        return self._made(scenario, index)

    @staticmethod
    def _made(scenario: Scenario, index: int) -> _core.VehicleSpec:
        with vehicle_errors_at(scenario, index):
            return vehicle_spec(scenario, scenario.vehicles[index])


def _require_no_programs(scenario: Scenario) -> None:
    """Refuse what Simulator does between steps, which the core does not know: it would be without effect."""
    if scenario.faults:
        rule = "faults with times run in a Simulator; in a batch set parameters, such as rov.thrusters.NAME.health"
        raise ValueError(f"faults: {rule}")
    for entry in scenario.vehicles:
        if entry.failsafe or entry.model.failsafe:
            raise ValueError(f"vehicle '{entry.name}': failsafe: runs in a Simulator, not in a batch")
