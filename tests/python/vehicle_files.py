"""Helpers that write the file of a valid box-shaped vehicle, and variations of it that are invalid."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import trimesh
import yaml

SIZE_M = (1.2, 0.8, 0.7)
SOUND: dict[str, Any] = {
    "name": "box",
    "mesh": "hull.obj",
    "buoyancy": "neutral",
    "centre_of_mass_m": [0.0, 0.0, -0.1],
    "linear_damping": [30, 50, 50, 60, 80, 30],
    "quadratic_damping": [300, 450, 500, 13, 30, 30],
    "added_mass": [250, 250, 250, 23, 40, 43],
    "max_force_n": [800, 300, 300],
    "max_torque_nm": [60, 60, 40],
}
OPEN_WATER: dict[str, Any] = {
    "name": "open_water",
    "water": {"density_kg_m3": 1000},  # the density that check_part assumes for a vehicle without a scenario
    "terrain": {"source": "noise", "size_m": [200, 200], "spacing_m": 2, "bed_depth_m": 60},
}


def box_mesh(path: Path, size_m: tuple[float, float, float] = SIZE_M, scale: float = 1.0) -> Path:
    """Write a box mesh whose sides are multiplied by `scale`."""
    trimesh.creation.box([scale * side for side in size_m]).export(path)
    return path


def vehicle_file(folder: Path, *, scale: float = 1.0, without: tuple[str, ...] = (), **changes: Any) -> Path:
    """Write the valid vehicle and its mesh, with changes applied. scale: of the mesh only."""
    box_mesh(folder / "hull.obj", changes.pop("size_m", SIZE_M), scale)
    path = folder / "box.yaml"
    path.write_text(yaml.safe_dump({key: value for key, value in {**SOUND, **changes}.items() if key not in without}))
    return path


def scenario_file(folder: Path, model: Path | str, **changes: Any) -> Path:
    """Write a scenario of deep open water with one vehicle, with changes applied."""
    vehicle = {"name": "rov", "model": str(model), "start": {"position_m": [0, 0, -20]}}
    path = folder / "open_water.yaml"
    path.write_text(yaml.safe_dump({**OPEN_WATER, "vehicles": [vehicle], **changes}))
    return path
