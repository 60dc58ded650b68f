"""A scenario's tethers as the core's TetherSpecs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from uwsim import _core
from uwsim.scenario.build.station import carrier_index, dock_position
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.tether import Anchor, BodyAnchor, Tether

SAME = (
    "length_m", "elements", "diameter_m", "mass_kg_m", "axial_stiffness_n", "bending_stiffness_n_m2",
    "axial_damping_n_s", "normal_drag", "tangential_drag", "normal_added_mass", "tangential_added_mass", "friction",
    "breaking_load_n",
)  # fmt: skip


def tether_specs(scenario: Scenario) -> dict[int, _core.TetherSpec]:
    """Return the core's spec of each tether by its vehicle's index."""
    return {
        index: _spec(scenario, index, entry.tether)
        for index, entry in enumerate(scenario.vehicles)
        if entry.tether is not None
    }


def tethered_through(scenario: Scenario, vehicle: str) -> list[str]:
    """Return the vehicles whose tethers a vehicle's cable goes through: its own, that of its anchor, and so on."""
    tethers = {entry.name: entry.tether for entry in scenario.vehicles if entry.tether is not None}
    found: list[str] = []
    while vehicle in tethers and vehicle not in found:
        found.append(vehicle)
        anchor = tethers[vehicle].anchor
        vehicle = anchor.to if isinstance(anchor, BodyAnchor) else ""
    return found


@contextmanager
def tether_errors_at(scenario: Scenario, index: int) -> Iterator[None]:
    """Prefix errors of a vehicle's tether with file, line and path."""
    file, keys = scenario.source_file, ("vehicles", index)
    try:
        yield
    except ValueError as error:
        raise ScenarioError(f"{file.line_prefix(*keys, 'tether')}{file.place(*keys)}.{error}") from None


def _first_end(scenario: Scenario, anchor: Anchor) -> _core.TetherEnd:
    """Return it. The core's bodies are the vehicles and then the objects."""
    if isinstance(anchor, BodyAnchor):
        bodies = [vehicle.name for vehicle in scenario.vehicles] + [body.name for body in scenario.objects]
        return _core.TetherEnd(anchor.at_m, bodies.index(anchor.to))
    if anchor != "station":
        return _core.TetherEnd(anchor)
    dock_m, carrier = dock_position(scenario.station), carrier_index(scenario)
    return _core.TetherEnd(dock_m) if carrier is None else _core.TetherEnd(dock_m, carrier)


def _spec(scenario: Scenario, index: int, tether: Tether) -> _core.TetherSpec:
    spec = _core.TetherSpec()
    spec.name = f"tether of '{scenario.vehicles[index].name}'"
    spec.first = _first_end(scenario, tether.anchor)
    spec.second = _core.TetherEnd(tether.at_m, index)
    for name in SAME:
        setattr(spec, name, getattr(tether, name))
    if tether.winch is not None:
        spec.longest_m = tether.winch.longest_m
        spec.shortest_m = tether.winch.shortest_m or 0.0
        spec.fastest_m_s = tether.winch.fastest_m_s
        spec.strongest_n = tether.winch.strongest_n
    return spec
