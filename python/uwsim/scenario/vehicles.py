"""Vehicles: their YAML files, their hulls, and the rigid body that a hull and a model make."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Literal

import numpy as np
import trimesh
from numpy.typing import NDArray

from uwsim.scenario.closing import closed_mesh
from uwsim.scenario.document import read_document
from uwsim.scenario.errors import ScenarioError
from uwsim.scenario.meshes import load_mesh
from uwsim.scenario.messages import validated
from uwsim.scenario.paths import assets_folder, find_yaml
from uwsim.scenario.vehicle_model import VehicleModel

VOLUME_SCALE = 0.1
"""Of lengths, by which a mesh may be scaled to a published volume: more makes it another vehicle."""


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A hull's mass properties, body frame.

    centre_of_buoyancy_m: (3,), of the whole hull under water. inertia_kg_m2: (3,), about the centre of mass along the
    body's axes.
    """

    volume_m3: float
    mass_kg: float
    centre_of_buoyancy_m: NDArray[np.float64]
    centre_of_mass_m: NDArray[np.float64]
    inertia_kg_m2: NDArray[np.float64]


def load_vehicle(source: str | Path, folder: Path | None = None) -> VehicleModel:
    """Load a vehicle from a packaged name ("rov") or a YAML file's path, relative to `folder`. Raises ScenarioError."""
    beside = (folder or Path()) / source
    path = beside if beside.is_file() else find_yaml(source, "vehicles")
    name = path.name if assets_folder() in path.parents else str(path)
    document = read_document(path, name)
    return validated(VehicleModel, document.values, document, folder=path.resolve().parent)


def vehicle_hull(model: VehicleModel) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    """Vertices (n, 3), body frame, and triangles (m, 3) of the closed hull, winding outward. Raises ScenarioError.

    Scaled evenly to the model's volume and moved to its centre of buoyancy, where it gives them.
    """
    name = str(model.mesh)
    file = model.mesh.stat() if model.mesh.is_file() else None
    stamp = (file.st_mtime_ns, file.st_size) if file else None
    vertices, triangles = _closed_hull(model.mesh, stamp, model.mesh_scale, model.mesh_up)
    if model.volume_m3 is None and model.centre_of_buoyancy_m is None:
        return vertices, triangles
    hull = trimesh.Trimesh(vertices, triangles, process=False)
    middle = np.asarray(hull.center_mass, np.float64)
    factor = 1.0 if model.volume_m3 is None else float(np.cbrt(model.volume_m3 / hull.volume))
    if not 1 - VOLUME_SCALE <= factor <= 1 + VOLUME_SCALE:
        raise ScenarioError(
            f"mesh '{name}': encloses {hull.volume:.4g} m3, volume_m3 = {model.volume_m3:.4g} m3: "
            f"lengths would scale by {factor:.3g}, must be within {VOLUME_SCALE:.0%}; mend the mesh or set mesh_scale"
        )
    there = middle if model.centre_of_buoyancy_m is None else np.asarray(model.centre_of_buoyancy_m)
    return (vertices - middle) * factor + there, triangles


@lru_cache(maxsize=16)
def _closed_hull(
    path: Path, stamp: tuple[int, int] | None, scale: float, up: Literal["y", "z"] | None
) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    """`stamp` changes with the file."""
    vertices, triangles = closed_mesh(*load_mesh(path, scale=scale, up=up), name=str(path))
    vertices.flags.writeable = False
    triangles.flags.writeable = False
    return vertices, triangles


def rigid_body(model: VehicleModel, water_density_kg_m3: float) -> RigidBody:
    """Mass properties: what the model gives, the rest from the hull as a solid of even density.

    Raises ScenarioError, also where the centre of mass is beside the hull.
    """
    hull = trimesh.Trimesh(*vehicle_hull(model), process=False)
    _require_mass_inside(model, hull.bounds)
    volume = float(hull.volume)
    density = water_density_kg_m3 if model.buoyancy == "neutral" else model.density_kg_m3
    mass = model.mass_kg if density is None else density * volume
    assert mass is not None  # the model has exactly one of the three
    if model.inertia_kg_m2 is not None:
        inertia = np.asarray(model.inertia_kg_m2)
    else:
        inertia = np.diagonal(hull.moment_inertia) * mass / volume
    return RigidBody(
        volume_m3=volume,
        mass_kg=mass,
        centre_of_buoyancy_m=np.asarray(hull.center_mass, np.float64),
        centre_of_mass_m=np.asarray(model.centre_of_mass_m),
        inertia_kg_m2=np.asarray(inertia, np.float64),
    )


def _require_mass_inside(model: VehicleModel, box_m: NDArray[np.float64]) -> None:
    """box_m: (2, 3), round the hull where it is placed: about its centre of buoyancy."""
    centre = np.asarray(model.centre_of_mass_m)
    if np.all(centre >= box_m[0]) and np.all(centre <= box_m[1]):
        return
    mass, low, high = (", ".join(f"{value:.4g}" for value in point) for point in (centre, *box_m))
    raise ScenarioError(
        f"vehicle '{model.name}': centre_of_mass_m = ({mass}) m: must be in the box round the hull, from ({low}) to "
        f"({high}) m, which is placed by its centre_of_buoyancy_m"
    )
