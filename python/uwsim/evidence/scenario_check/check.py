"""check_file: reports all mistakes in a scenario file or, if there are none, its scene and likely oversights."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from uwsim.base.caught_warnings import caught_warnings
from uwsim.base.texts.yaml_document import YamlDocument
from uwsim.evidence.scenario_check.report import CheckReport
from uwsim.evidence.scenario_check.scene import measured_scene
from uwsim.evidence.scenario_check.surprises import surprises
from uwsim.flight.flyable_lanes import checked
from uwsim.scenario import Scenario, ScenarioError, build_world, load
from uwsim.scenario.build.vehicle import vehicle_control, vehicle_errors_at, vehicle_spec
from uwsim.scenario.build.world import scenario_water
from uwsim.scenario.read.assets import find_yaml, shown_name
from uwsim.scenario.read.errors import Collected
from uwsim.scenario.read.remainder import Remainder
from uwsim.scenario.read.spec_file import SourceFile, read_yaml
from uwsim.scenario.read.validated import what_holds
from uwsim.simulator.simulator import Simulator

STAND_INS: dict[str, Any] = {
    "name": "unnamed",
    "vehicles": [{"name": "stand_in", "model": "rov", "start": {"position_m": [0, 0, 0]}}],
}
"""Stand-ins for invalid values that cannot be left out, so that the rest of the file can be checked."""


def check_file(source: str | Path) -> CheckReport:
    """Return the report on a packaged scenario or a YAML file. Mistakes in the file are reported rather than raised."""
    try:
        path = find_yaml(source, "scenarios")
        document = read_yaml(path, shown_name(path))
    except ScenarioError as error:
        return CheckReport(str(source), error.mistakes)
    found = checked(lambda: load(source))
    if (sim := found.simulator) is None:
        with caught_warnings():
            return CheckReport(document.name, _mistakes(document, path.resolve().parent) or found.mistakes)
    if mistakes := (*_fault_mistakes(sim), *found.mistakes):
        return CheckReport(document.name, mistakes)
    with caught_warnings() as issued:  # again, since the scene builds water of its own
        scene = measured_scene(sim)
    warned = dict.fromkeys((*found.warnings, *(str(each.message) for each in issued), *surprises(sim, scene)))
    return CheckReport(document.name, (), tuple(warned), scene, sim)


def _fault_mistakes(sim: Simulator) -> tuple[str, ...]:
    """Return the faults that would stop the flight in which they begin, by what they make of vehicle or water."""
    found = Collected()
    for index, fault in enumerate(sim.scenario.faults):
        with found.noted():
            try:
                changed = sim.parameters.scenario_with(sim.faults.overlay_of(fault))
                scenario_water(changed, sim.world)
                for vehicle in changed.vehicles:
                    vehicle_spec(changed, vehicle)
            except ValueError as error:
                line = sim.scenario.source_file.line_prefix("faults", index)
                raise ScenarioError(f"{line}faults[{index}]: while it lasts: {error}") from None
    return tuple(found.mistakes)


def _mistakes(document: YamlDocument, folder: Path) -> tuple[str, ...]:
    """Return the mistakes in individual values, then those found by building a world from the valid values."""
    holding = what_holds(Scenario, document.values, document, folder)
    scenario = holding.model
    if scenario is None:
        values = {**STAND_INS, **holding.left.values}
        scenario = what_holds(Scenario, values, None, folder).model
    if scenario is None or ("terrain",) in holding.left.left_out.around:
        return tuple(holding.mistakes)
    sound = _sound(scenario, document, holding.left)
    found = Collected()
    with found.noted():
        build_world(sound)
    for index, vehicle in enumerate(sound.vehicles):
        with found.noted(), vehicle_errors_at(sound, index):
            spec = vehicle_spec(sound, vehicle)
            vehicle_control(sound, vehicle.model, spec)
    return (*holding.mistakes, *found.mistakes)


def _sound(scenario: Scenario, document: YamlDocument, left: Remainder) -> Scenario:
    """Return the scenario without the obstacles and vehicles that have invalid parts."""
    spoilt = {path[:2] for path in left.left_out.places}
    is_spoilt = {path[0] for path in left.left_out.places}
    kept: dict[str, Any] = {}
    order: dict[str, list[int]] = {}
    for kind in ("obstacles", "vehicles", "objects"):
        items = enumerate(getattr(scenario, kind))
        sound = [(left.in_file((kind, k))[1], item) for k, item in items if left.in_file((kind, k)) not in spoilt]
        if kind not in left.values:  # stand-ins only
            sound = []
        if "station" in is_spoilt and kind == "vehicles":
            sound = [(k, vehicle) for k, vehicle in sound if vehicle.start is not None]
        order[kind] = [int(k) for k, _ in sound]
        kept[kind] = tuple(item for _, item in sound)
    if "survey" in is_spoilt:
        kept["survey"] = None
    source = SourceFile(document, in_file=lambda keys: _in_file(tuple(keys), order))
    return scenario.model_copy(update=kept).read_from(source)


def _in_file(keys: tuple[str | int, ...], order: dict[str, list[int]]) -> tuple[str | int, ...]:
    if len(keys) > 1 and keys[0] in order and isinstance(keys[1], int):
        return (keys[0], order[str(keys[0])][keys[1]], *keys[2:])
    return keys
