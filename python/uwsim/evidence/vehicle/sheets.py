"""A packaged vehicle beside what its makers and owners state of it: assets/claims/vehicles.yaml."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal

import numpy as np
from scipy.optimize import brentq

from uwsim.evidence.validate.flights import deep_water
from uwsim.scenario import ScenarioError, VehicleModel
from uwsim.scenario.read.spec_file import read_spec
from uwsim.scenario.spec.fields import Model

SUPPLY_V = 16.0
GLIDE_S, PITCHES = 200.0, (0.2, 0.35, 0.5)
"""How long a glide takes to settle, and the shares of the moving mass's travel that are tried."""
Quantity = Literal[
    "speed_ahead", "speed_over_ground", "thrust_ahead", "thrust_aside", "thrust_up", "turning_radius", "hover_power",
    "endurance",
]  # fmt: skip
SHOWN: dict[Quantity, tuple[str, str]] = {
    "speed_ahead": ("speed at full ahead", "m/s"),
    "speed_over_ground": ("greatest speed over ground at full pump", "m/s"),
    "thrust_ahead": ("thrust ahead at rest", "N"),
    "thrust_aside": ("thrust to the side at rest", "N"),
    "thrust_up": ("thrust upward at rest", "N"),
    "turning_radius": ("turning radius at full ahead", "m"),
    "hover_power": (f"electric power of hovering at {SUPPLY_V:g} V", "W"),
    "endurance": ("endurance", "h"),
}
"""The quantities: text and unit."""


class Statement(Model):
    """A value in the unit of SHOWN. year: None if undated."""

    vehicles: tuple[str, ...]
    quantity: Quantity
    value: float
    year: int | None = None
    source: str


class Statements(Model):
    """The file."""

    statements: tuple[Statement, ...]


def beside_makers(report: Any) -> Iterator[tuple[str, str, str, str, str]]:
    """Yield rows: quantity, value here, stated value, year, source; "-" where there is none.

    Endurance is not computed: it depends on the power of computers, lamps and payload, which is not modelled.
    """
    here = _here(report)
    stated = {
        each.quantity: each
        for each in read_spec(Statements, "vehicles", "claims").statements
        if report.model.name in each.vehicles
    }
    for quantity, (text, unit) in SHOWN.items():
        found, value = stated.get(quantity), here.get(quantity, np.nan)
        if found is None and not np.isfinite(value):
            continue
        yield (
            f"{text} [{unit}]",
            f"{value:.3g}" if np.isfinite(value) else "-",
            "-" if found is None else f"{found.value:g}",
            "-" if found is None or found.year is None else str(found.year),
            "" if found is None else found.source,
        )


def _here(report: Any) -> dict[Quantity, float]:
    found: dict[Quantity, float] = {"speed_ahead": float(report.terminal[0, 0])}
    if np.isfinite(report.terminal[0, 0]):
        ahead, aside, up = report.allocation.full_ahead[:3]
        found |= {"thrust_ahead": ahead, "thrust_aside": aside or np.nan, "thrust_up": up or np.nan}
    if report.circles:
        found["turning_radius"] = report.circles[-1].radius_m
    if report.figures.glides and not np.isfinite(report.terminal[0, 0]):
        found["speed_over_ground"] = _glide_m_s(report.model)
    if (power_w := hover_power_w(report.model, report.figures.net_buoyancy_n)) is not None:
        found["hover_power"] = power_w
    return found


def hover_power_w(model: VehicleModel, net_buoyancy_n: float) -> float | None:
    """Return the electric power of the upright thrusters that hold a net buoyancy; None without their sheets.

    A vehicle that rises thrusts downward. The sheets have no current within the dead band.
    """
    upright = [mount for mount in model.thrusters.values() if abs(mount.axis[2]) > 0.99 * np.linalg.norm(mount.axis)]
    try:
        sheets = [mount.model.performance(mount.gain) for mount in upright]
    except ScenarioError:
        return None
    if not sheets:
        return None
    wanted_n, sign = abs(net_buoyancy_n), -np.sign(net_buoyancy_n)

    def over_n(command: float) -> float:
        return float(sum(abs(each.at(sign * command, SUPPLY_V)[0]) for each in sheets)) - wanted_n

    if wanted_n == 0.0 or over_n(1.0) < 0.0:
        return 0.0 if wanted_n == 0.0 else None
    command = float(brentq(over_n, 0.0, 1.0))
    return float(sum(SUPPLY_V * each.at(sign * command, SUPPLY_V)[1] for each in sheets))


def _glide_m_s(model: VehicleModel) -> float:
    """Return the greatest horizontal speed of a glider that sinks with its engine full, over some pitches."""
    engines = {name: -1.0 for name, mount in model.thrusters.items() if mount.force == "buoyancy"}
    masses = [name for name, mount in model.thrusters.items() if mount.force == "weight"]
    speeds = []
    for share in PITCHES:
        sim = deep_water(model, density_kg_m3=1025.0, step_s=0.02)
        sim.rov.set_thrusters(engines | dict.fromkeys(masses, -share))
        sim.advance(GLIDE_S)
        turn = sim.rov.pose.world_from_body[:3, :3]
        speeds.append(float(np.hypot(*(turn @ sim.rov.velocity.linear_body_m_s)[:2])))
    return max(speeds)
