"""Flat water and open lakes with vehicles, for tests of what happens in them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from uwsim.scenario import Scenario, load
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.read.validated import validated


def rov(model: Any = "bluerov2_heavy", position_m: Any = (0, 0, -5), **more: Any) -> dict[str, Any]:
    """Return the entry of a vehicle named rov."""
    return {"name": "rov", "model": model, "start": {"position_m": list(position_m)}} | more


def flat(*vehicles: dict[str, Any], bed_m: float = -10.0, size_m: float = 60, **changes: Any) -> Scenario:
    """Return a square of water above a flat bed, with vehicles."""
    terrain = {"source": "noise", "size_m": [size_m] * 2, "spacing_m": size_m / 60, "bed_depth_m": -bed_m}
    terrain["hill_height_m"] = 0
    return validated(Scenario, {"name": "site", "terrain": terrain, "vehicles": list(vehicles)} | changes)


def lake(model: Any, position_m: Any = (0, 0, 0), size_m: float = 800, bed_m: float = -60, **changes: Any) -> Scenario:
    """Return open water with a vehicle, named boat."""
    terrain = {"source": "noise", "size_m": [size_m, size_m], "spacing_m": size_m / 40, "bed_depth_m": -bed_m}
    boat = {"name": "boat", "model": model, "start": {"position_m": list(position_m)}}
    values = {"name": "open", "mission_time_s": 900, "water": {"density_kg_m3": 1025}, "terrain": terrain}
    return validated(Scenario, values | {"vehicles": [boat]} | changes)


def gusty_pool(folder: Path) -> Path:
    """Write the pool with waves and gusts, both of which depend on the seed."""
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    waves = "\nwater:\n  surface: {kind: jonswap, significant_height_m: 0.3, peak_period_s: 3.0, component_count: 16}\n"
    gusts = "  current:\n    - {kind: gusts, sigma_m_s: [0.1, 0.1, 0.0], correlation_time_s: 5.0}\n"
    path = folder / "gusty.yaml"
    assert text.count("\nwater:\n") == 1
    path.write_text(text.replace("\nwater:\n", waves + gusts))
    return path


def deep_lake(
    *faults: dict[str, Any], model: str | None = None, failsafe: dict[str, Any] | None = None, yaw_deg: float = 0.0
) -> Scenario:
    """Return the lake with its vehicle undocked, 12 m deep. model: of another vehicle, without a sonar."""
    base = load("lake")
    start = {"position_m": [-60.0, -40.0, -12.0], "yaw_deg": yaw_deg}
    other = {"model": model, "sonar": {}} if model else {}
    vehicle = {**dict(base.vehicles[0]), "start": start, "failsafe": failsafe, **other}
    plain = {key: getattr(base, key) for key in type(base).model_fields}
    return Scenario.model_validate({**plain, "vehicles": [vehicle], "faults": list(faults)})
