"""A scenario's tethers as the core's TetherSpecs."""

from __future__ import annotations

from uwsim import _core
from uwsim.scenario.build.station import carrier_index, dock_position
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.tether import Anchor, BodyAnchor, Tethered

SAME = (
    "length_m", "elements", "diameter_m", "mass_kg_m", "axial_stiffness_n", "bending_stiffness_n_m2",
    "axial_damping_n_s", "normal_drag", "tangential_drag", "normal_added_mass", "tangential_added_mass", "friction",
    "breaking_load_n",
)  # fmt: skip


def tether_specs(scenario: Scenario) -> dict[str, _core.TetherSpec]:
    """Return the core's spec of each tether by the name of its vehicle or object, in order."""
    return {one.name: _spec(scenario, one) for one in scenario.tethered}


def tethered_through(scenario: Scenario, name: str) -> list[str]:
    """Return whose tethers the cable of a vehicle or object goes through: its own, that of its anchor, and so on."""
    tethers = {one.name: one.tether for one in scenario.tethered}
    found: list[str] = []
    while name in tethers and name not in found:
        found.append(name)
        anchor = tethers[name].anchor
        name = anchor.to if isinstance(anchor, BodyAnchor) else ""
    return found


def add_tethers(scenario: Scenario, simulation: _core.Simulation) -> None:
    """Add the tethers to a simulation, after all vehicles and objects. Raises ScenarioError, with its place."""
    file = scenario.source_file
    for one in scenario.tethered:
        try:
            simulation.add_tether(_spec(scenario, one))
        except ValueError as error:
            raise ScenarioError(f"{file.line_prefix(*one.keys, 'tether')}{file.place(*one.keys)}.{error}") from None


def _first_end(scenario: Scenario, anchor: Anchor) -> _core.TetherEnd:
    """Return it. The core's bodies are the vehicles and then the objects."""
    if isinstance(anchor, BodyAnchor):
        bodies = [vehicle.name for vehicle in scenario.vehicles] + [body.name for body in scenario.objects]
        return _core.TetherEnd(anchor.at_m, bodies.index(anchor.to))
    if anchor != "station":
        return _core.TetherEnd(anchor)
    dock_m, carrier = dock_position(scenario.station), carrier_index(scenario)
    return _core.TetherEnd(dock_m) if carrier is None else _core.TetherEnd(dock_m, carrier)


def _spec(scenario: Scenario, one: Tethered) -> _core.TetherSpec:
    spec, tether = _core.TetherSpec(), one.tether
    spec.name = f"tether of '{one.name}'"
    spec.first = _first_end(scenario, tether.anchor)
    spec.second = _core.TetherEnd(tether.at_m, one.body)
    for name in SAME:
        setattr(spec, name, getattr(tether, name))
    if tether.winch is not None:
        spec.longest_m = tether.winch.longest_m
        spec.shortest_m = tether.winch.shortest_m or 0.0
        spec.fastest_m_s = tether.winch.fastest_m_s
        spec.strongest_n = tether.winch.strongest_n
    return spec
