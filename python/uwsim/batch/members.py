"""What each member of a batch is built from."""

from __future__ import annotations

from uwsim import _core
from uwsim.batch.arguments import Changes
from uwsim.parameters import Parameters
from uwsim.scenario import Scenario
from uwsim.scenario.build.link import link_spec
from uwsim.scenario.build.simulation import simulation_spec
from uwsim.scenario.build.vehicle import vehicle_errors_at, vehicle_spec
from uwsim.scenario.build.water import surface_density_kg_m3
from uwsim.scenario.build.world import scenario_water


class Members:
    """Makes the specs of members of one scenario and world, which share the vehicles that are the same.

    vehicles: the scenario's own, without a member's parameters.
    """

    def __init__(self, scenario: Scenario, world: _core.World) -> None:
        _require_no_programs(scenario)
        self._scenario = scenario
        self._world = world
        self.vehicles = [self._made(scenario, index) for index in range(len(scenario.vehicles))]

    def member(self, index: int, seed: int, changes: Changes) -> _core.MemberSpec:
        """Return what the member of a place, seed and parameters is built from. Raises ValueError that names it."""
        scenario = self._scenario.with_changes(seed=seed)
        try:
            if changes:
                parameters = Parameters(scenario, lambda _: None, lambda *_, **__: None, {})
                parameters.update(changes)
                scenario = parameters.scenario
                _require_no_programs(scenario)
            vehicles = [self._vehicle(scenario, k) for k in range(len(scenario.vehicles))]
            water = scenario_water(scenario, self._world)
        except ValueError as error:
            raise ValueError(f"batch[{index}]: {error}") from None
        link = None if scenario.link is None else link_spec(scenario.link, scenario.station)
        return _core.MemberSpec(water, simulation_spec(scenario), vehicles, link)

    def _vehicle(self, scenario: Scenario, index: int) -> _core.VehicleSpec:
        same_trim = surface_density_kg_m3(scenario.water) == surface_density_kg_m3(self._scenario.water)
        if same_trim and scenario.vehicles[index] == self._scenario.vehicles[index]:
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
