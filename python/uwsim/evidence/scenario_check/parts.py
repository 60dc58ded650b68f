"""check_part: checks a file to which scenarios refer, such as a vehicle file, by building its contents."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from uwsim import _core
from uwsim.base.named import did_you_mean
from uwsim.evidence.scenario_check.report import CheckReport
from uwsim.evidence.vehicle.figures import VehicleFigures, vehicle_figures
from uwsim.evidence.vehicle.surprises import FRESH_KG_M3, buoyancy_surprises, vehicle_surprises
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.build.equipment import battery_spec, sensor_spec, thrust_curve
from uwsim.scenario.build.loose_bodies import object_specs
from uwsim.scenario.build.multibeam import acoustic_spec, multibeam_model
from uwsim.scenario.build.solids import obstacle_solid
from uwsim.scenario.build.station import modem_spec
from uwsim.scenario.build.terrain import build_terrain
from uwsim.scenario.read.assets import find_yaml, shown_name
from uwsim.scenario.read.spec_file import read_yaml
from uwsim.scenario.read.validated import validated, what_holds
from uwsim.scenario.schema import FILES
from uwsim.scenario.spec.actuator import ThrusterType
from uwsim.scenario.spec.battery import BatterySetup, BatteryType
from uwsim.scenario.spec.link import ModemModel
from uwsim.scenario.spec.prop import Prop
from uwsim.scenario.spec.sensor import SensorSet
from uwsim.scenario.spec.sonar import ACOUSTIC, SonarModel
from uwsim.simulator.simulator import Simulator

OPEN_WATER: dict[str, Any] = {
    "name": "open_water",
    "water": {"density_kg_m3": FRESH_KG_M3},
    "terrain": {"source": "noise", "size_m": [2000, 2000], "spacing_m": 50, "bed_depth_m": 1000},
}
"""Scenario values for checking a vehicle's file: deep, still, fresh water."""


def check_part(source: str | Path, kind: str) -> CheckReport:
    """Return the report on a file of one of the kinds in uwsim.scenario.schema.FILES, such as a vehicle file.

    The check builds the contents: for a vehicle, its hull, mass, actuators and all instruments, in open water. Raises
    ValueError if the kind is unknown.
    """
    if kind not in FILES:
        raise ValueError(f"kind '{kind}': must be one of {', '.join(FILES)}{did_you_mean(kind, FILES)}")
    try:
        path = find_yaml(source, kind if kind.endswith("s") else f"{kind}s")
        document = read_yaml(path, shown_name(path))
    except ScenarioError as error:
        return CheckReport(str(source), error.mistakes)
    holding = what_holds(FILES[kind], document.values, document, path.resolve().parent)
    if holding.mistakes or holding.model is None:
        return CheckReport(document.name, tuple(holding.mistakes))
    if kind == "scenario":
        from uwsim.evidence.scenario_check.check import check_file

        return check_file(source)
    if kind == "vehicle":
        return _vehicle_report(document.name, path)
    try:
        BUILT[kind](holding.model)
    except ValueError as error:  # including ScenarioError
        return CheckReport(document.name, (f"{document.name}: {error}",))
    return CheckReport(document.name, ())


def _vehicle_report(name: str, path: Path) -> CheckReport:
    start = {"position_m": [0.0, 0.0, -100.0]}
    values = {**OPEN_WATER, "vehicles": [{"name": "vehicle", "model": str(path.resolve()), "start": start}]}
    with warnings.catch_warnings(record=True) as issued:
        warnings.simplefilter("always", UserWarning)
        try:
            sim = Simulator(validated(Scenario, values))
            figures, found = _measured(sim)
        except ScenarioError as error:
            return CheckReport(name, tuple(mistake.removeprefix("vehicles[0].model: ") for mistake in error.mistakes))
    notes = [str(each.message) for each in issued if issubclass(each.category, UserWarning)]
    return CheckReport(name, (), (*dict.fromkeys(notes), *found), simulator=sim, vehicle=figures)


def _measured(sim: Simulator) -> tuple[VehicleFigures, list[str]]:
    entry, control = sim.scenario.vehicles[0], sim.rov.control.model
    figures = vehicle_figures(entry.model, control, FRESH_KG_M3, entry.trim)
    source = entry.model.source_file
    found = [*vehicle_surprises(figures)]
    if entry.model.buoyancy is None and entry.model.trim is None:
        found += buoyancy_surprises(figures)
    return figures, [f"{source.line_prefix(*keys) if keys else source.file_prefix}{text}" for keys, text in found]


def _build_sensors(part: SensorSet) -> None:
    for name, sensor in part.sensors.items():
        sensor_spec(name, sensor)


def _build_sonar(part: SonarModel) -> None:
    for band in part.frequencies:
        multibeam_model(part, band.frequency_hz)
        if all(getattr(band, key) is not None for key in ACOUSTIC):
            acoustic_spec(part, band.frequency_hz)


def _build_modem(part: ModemModel) -> _core.ModemSpec | None:
    return None if part.kind == "none" else modem_spec(part)


def _build_thruster(part: ThrusterType) -> None:
    thrust_curve(part)
    if part.sheets is not None:
        part.performance()


def _build_battery(part: BatteryType) -> None:
    battery_spec(BatterySetup(model=part))


def _build_prop(part: Prop) -> None:
    start, place = {"position_m": [50.0, 0.0, -100.0]}, {"name": part.name, "model": part, "position_m": [0, 0, -100]}
    vehicle = {"name": "vehicle", "model": "rov", "start": start}
    scenario = validated(Scenario, {**OPEN_WATER, "vehicles": [vehicle], "props": [place]})
    terrain = build_terrain(scenario.terrain)
    for obstacle in scenario.obstacles:
        obstacle_solid(obstacle, terrain)
    object_specs(scenario)


BUILT: Mapping[str, Callable[[Any], object]] = {
    "thruster": _build_thruster,
    "sensors": _build_sensors,
    "sonar": _build_sonar,
    "modem": _build_modem,
    "battery": _build_battery,
    "prop": _build_prop,
}
