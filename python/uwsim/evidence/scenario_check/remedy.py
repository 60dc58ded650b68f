"""The YAML that gives a scenario's first vehicle what it lacks to fly the survey: proposals, not measured."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from textwrap import indent
from typing import Any

import numpy as np

from uwsim.base.axes import AXES
from uwsim.evidence.vehicle.draft_actuators import Body, needed_wrench, proposed_thrusters
from uwsim.flight.flyable_lanes import required_survey
from uwsim.missions.lawn_mower_needs import ALTIMETER, SONAR
from uwsim.navigation.sensor_choice import altimeter
from uwsim.scenario.build.hull import rigid_body, vehicle_hull
from uwsim.scenario.dump import plain, yaml_text
from uwsim.scenario.spec.vehicle import PARTS, VehicleModel
from uwsim.simulator.simulator import Simulator

ALTITUDE = {"kind": "altitude", "rate_hz": 15, "noise": {"std": 0.0024}}
RANGE_M = 100.0
"""Least range of a proposed altimeter, as that of a Ping; the errors are those of the packaged sensors `bluerov2`."""


def remedy(sim: Simulator, missing: Collection[str]) -> str:
    """Return lines of YAML that replace `model:` of the first vehicle's entry. missing: as by missing_for_lanes."""
    model = sim.scenario.vehicles[0].model
    body = _body(model, sim.world.water.density_kg_m3)
    low, high = body.low_m, body.high_m
    added: dict[str, Any] = {}
    if SONAR in missing:
        added["sonar"] = {"position_m": _rounded([0.9 * high[0], 0.0, low[2]])}
    if ALTIMETER in missing:
        added["sensors"] = _altimeter(sim, low, max(RANGE_M, 2.0 * required_survey(sim.scenario).altitude_m))
    if axes := [axis for axis in AXES if axis in missing]:
        added |= _actuators(model, body, axes)
    document = sim.scenario.source_file.document
    assert document is not None  # of the file that is checked
    written = document.values["vehicles"][0]["model"]
    built = {"model": _built_on(written, model, added)}
    column = document.column(("vehicles", 0))
    return f"{json.dumps(built)[1:-1]}\n" if column is None else indent(yaml_text(built), " " * column)


def _altimeter(sim: Simulator, low_m: np.ndarray[Any, Any], range_m: float) -> dict[str, Any]:
    if (found := altimeter(sim.rov.sensors)) is None:
        return {"altitude": ALTITUDE | {"position_m": _rounded([0.0, 0.0, low_m[2]]), "range_max_m": range_m}}
    mount = plain(sim.scenario.vehicles[0].model.sensors[found.name])
    parameters = {key: values[0] for key, values in mount.pop("parameters", {}).items()}
    return {found.name: mount | parameters | {"on": True, "range_max_m": range_m}}


def _actuators(model: VehicleModel, body: Body, axes: Collection[str]) -> dict[str, Any]:
    """Return thrusters, or forces for a vehicle without, that drive the axes."""
    if model.thrusters:
        return {
            "thrusters": {
                f"proposed_{each.name}": {
                    "model": "t200_16v", "position_m": _rounded(each.position_m), "axis": _rounded(each.axis),
                    "spin": each.spin, "gain": round(each.gain, 2),
                }
                for each in proposed_thrusters(body, axes)
            }
        }  # fmt: skip
    wrench = np.concatenate([model.max_force_n or np.zeros(3), model.max_torque_nm or np.zeros(3)])
    most = _rounded(np.maximum(wrench, needed_wrench(body, axes)))
    return {"max_force_n": most[:3], "max_torque_nm": most[3:]}


def _body(model: VehicleModel, density_kg_m3: float) -> Body:
    vertices, _ = vehicle_hull(model)
    rigid = rigid_body(model, density_kg_m3)
    drag = np.diagonal(model.matrix("quadratic_damping"))
    return Body(
        vertices.min(axis=0), vertices.max(axis=0), rigid.mass_kg, rigid.inertia_kg_m2, model.matrix("added_mass"),
        drag, (float(drag[0]), float(drag[0])), model.munk_share, 0.0, density_kg_m3,
    )  # fmt: skip


def _built_on(written: Any, model: VehicleModel, added: Mapping[str, Any]) -> dict[str, Any]:
    """Return a model in place: what was written, with what is added; sensors in a file of their own are written out."""
    if not isinstance(written, Mapping):
        return {"builds_on": str(written), **added}
    merged = {**written, **added}
    for key in set(PARTS) & added.keys() & written.keys():
        parts = written[key] if isinstance(written[key], Mapping) else plain(getattr(model, key))
        merged[key] = {**parts, **added[key]}
    return merged


def _rounded(values: Any) -> list[float]:
    return [float(f"{value:.4g}") + 0.0 for value in values]
