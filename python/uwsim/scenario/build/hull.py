"""A vehicle's hull and mass properties, and where it floats upright at rest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scenario.build.scale import question_of_factor, require_plausible_density, require_plausible_volume
from uwsim.scenario.read.disk_cache import cached_arrays
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.mesh_file import Forward, Up, load_mesh
from uwsim.scenario.read.mesh_repair import closed_mesh
from uwsim.scenario.spec.fields import Point3
from uwsim.scenario.spec.vehicle import VehicleModel

SELF_FILTER_MARGIN_M = 0.05
MAX_SCALING = 0.1
"""Largest relative change of length when a mesh is scaled to a published volume; more would make it a different
vehicle."""


@dataclass(frozen=True, eq=False)
class RigidBody:
    """The mass properties of a vehicle, body frame.

    centre_of_buoyancy_m: (3,), for the fully submerged hull. inertia_kg_m2: (3,), about the centre of mass along the
    body axes.
    """

    volume_m3: float
    mass_kg: float
    centre_of_buoyancy_m: NDArray[np.float64]
    centre_of_mass_m: NDArray[np.float64]
    inertia_kg_m2: NDArray[np.float64]


class _Solid(NamedTuple):
    """Volume integrals of a closed mesh. centroid_m: (3,). inertia_m5: (3,), about the centroid, for a density of 1."""

    volume_m3: float
    centroid_m: NDArray[np.float64]
    inertia_m5: NDArray[np.float64]


class _Hull(NamedTuple):
    """A closed hull. vertices_m: (n, 3), body frame. triangles: (m, 3)."""

    vertices_m: NDArray[np.float64]
    triangles: NDArray[np.uint32]
    solid: _Solid


def vehicle_hull(model: VehicleModel) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    """Return the vertices (n, 3), body frame, and outward-wound triangles (m, 3) of the closed hull.

    The mesh is scaled uniformly to the model's volume and moved to its centre of buoyancy, where the model specifies
    them. Both arrays are shared and read-only. Raises ScenarioError.
    """
    hull = _placed(model)
    return hull.vertices_m, hull.triangles


def hull_placement(model: VehicleModel) -> tuple[float, NDArray[np.float64]]:
    """Return the factor and the shift (3,) [m] from the file's scaled and turned mesh to the body frame."""
    in_file, _ = load_mesh(model.mesh, model.mesh_scale, model.mesh_up, model.mesh_forward or "x")
    in_body, _ = vehicle_hull(model)
    factor = float(np.ptp(in_body[:, 0]) / np.ptp(in_file[:, 0]))
    return factor, in_body.min(axis=0) - factor * in_file.min(axis=0)


def hull_box_m(model: VehicleModel) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the low and high corners (3,) of a box around the hull, body frame; echoes from inside it are dropped."""
    vertices, _ = vehicle_hull(model)
    return vertices.min(axis=0) - SELF_FILTER_MARGIN_M, vertices.max(axis=0) + SELF_FILTER_MARGIN_M


def _placed(model: VehicleModel) -> _Hull:
    file = model.mesh.stat() if model.mesh.is_file() else None
    version = (file.st_mtime_ns, file.st_size) if file else None
    hull = _placed_hull(
        *(model.mesh, version, model.mesh_scale, model.mesh_up, model.mesh_forward or "x"),
        *(model.volume_m3, model.centre_of_buoyancy_m),
    )
    size_m = np.ptp(hull.vertices_m, axis=0)
    require_plausible_volume(model.name, hull.solid.volume_m3, size_m, model.mesh_scale, model.mass_kg)
    return hull


@lru_cache(maxsize=64)
def _placed_hull(
    path: Path,
    version: tuple[int, int] | None,
    scale: float,
    up: Up | None,
    forward: Forward,
    volume_m3: float | None,
    centre_of_buoyancy_m: Point3 | None,
) -> _Hull:
    """Scale, move and measure the closed mesh. version: identifies the state of the file, to keep the cache current."""
    hull = _closed_hull(path, version, scale, up, forward)
    if volume_m3 is None and centre_of_buoyancy_m is None:
        return hull
    factor = 1.0 if volume_m3 is None else float(np.cbrt(volume_m3 / hull.solid.volume_m3))
    if not 1 - MAX_SCALING <= factor <= 1 + MAX_SCALING:
        raise ScenarioError(
            f"mesh '{path}': encloses {hull.solid.volume_m3:.4g} m3, volume_m3 = {volume_m3:.4g} m3: lengths would "
            f"scale by {factor:.3g}, must be within {MAX_SCALING:.0%}; repair the mesh or set mesh_scale"
            f"{question_of_factor(factor, scale)}",
            at=("volume_m3",),
        )
    centroid = hull.solid.centroid_m
    target = centroid if centre_of_buoyancy_m is None else np.asarray(centre_of_buoyancy_m)
    vertices = (hull.vertices_m - centroid) * factor + target
    vertices.flags.writeable = False
    return _Hull(vertices, hull.triangles, _solid(vertices, hull.triangles))


def hull_radius_m(model: VehicleModel) -> float:
    """Return the radius of the smallest sphere about the vehicle's origin that encloses its hull."""
    return float(np.linalg.norm(vehicle_hull(model)[0], axis=1).max())


@lru_cache(maxsize=16)
def _closed_hull(path: Path, version: tuple[int, int] | None, scale: float, up: Up | None, forward: Forward) -> _Hull:
    """Read the mesh, close it and measure it. version: see _placed_hull."""
    vertices, triangles = closed_mesh(*load_mesh(path, scale, up, forward), name=str(path))
    vertices.flags.writeable = False
    triangles.flags.writeable = False
    return _Hull(vertices, triangles, _solid(vertices, triangles))


def _solid(vertices_m: NDArray[np.float64], triangles: NDArray[np.uint32]) -> _Solid:
    """Return the properties of a closed mesh as a solid of density 1."""

    def measure() -> tuple[NDArray[np.float64], ...]:
        from uwsim.base.whole_trimesh import trimesh

        solid = trimesh.Trimesh(vertices_m, triangles, process=False)
        return np.array(solid.volume), np.asarray(solid.center_mass), np.diagonal(solid.moment_inertia).copy()

    volume, centroid, inertia = cached_arrays(measure, "solid", vertices_m, triangles)
    return _Solid(
        float(volume[()]),
        np.asarray(centroid, np.float64),
        np.asarray(inertia, np.float64),
    )


def rigid_body(model: VehicleModel, water_density_kg_m3: float) -> RigidBody:
    """Return the mass properties; those not specified are computed from the hull as a solid of uniform density.

    Raises ScenarioError, also for an implausible size or mean density, or a centre of mass outside the hull's bounding
    box.
    """
    vertices, _, hull = _placed(model)
    volume = hull.volume_m3
    density = water_density_kg_m3 if model.buoyancy == "neutral" else model.density_kg_m3
    mass = model.mass_kg if density is None else density * volume
    assert mass is not None  # a model specifies exactly one of the three
    require_plausible_density(model.name, mass, volume, model.mesh_scale, "a mass")
    _require_mass_inside(model, np.stack([vertices.min(axis=0), vertices.max(axis=0)]))
    given = model.inertia_kg_m2
    inertia = hull.inertia_m5 * mass / volume if given is None else np.asarray(given)
    return RigidBody(
        volume_m3=volume,
        mass_kg=mass,
        centre_of_buoyancy_m=hull.centroid_m,
        centre_of_mass_m=np.asarray(model.centre_of_mass_m),
        inertia_kg_m2=np.asarray(inertia, np.float64),
    )


def _require_mass_inside(model: VehicleModel, box_m: NDArray[np.float64]) -> None:
    """Raise ScenarioError for a centre of mass outside box_m (2, 3), the bounding box of the placed hull."""
    centre = np.asarray(model.centre_of_mass_m)
    if np.all(centre >= box_m[0]) and np.all(centre <= box_m[1]):
        return
    mass, low, high = (", ".join(f"{value:.4g}" for value in point) for point in (centre, *box_m))
    raise ScenarioError(
        f"vehicle '{model.name}': centre_of_mass_m = ({mass}) m: must be in the hull's bounding box, from ({low}) to "
        f"({high}) m, which is placed by its centre_of_buoyancy_m",
        at=("centre_of_mass_m",),
    )


def hull_scene(vertices_m: NDArray[np.float64], triangles: NDArray[np.integer]) -> _core.RayScene:
    """Return a scene for rays that contains only a hull (n, 3), (m, 3), in body coordinates."""
    world = _core.World()
    world.add_solid("hull", vertices_m, triangles)
    return _core.RayScene(world)


BOAT = 0.9
"""The largest share of its hull that a boat's weight submerges; divers' vehicles have 0.97 and more."""
HALVINGS = 50
GRAVITY_M_S2 = 9.80665


def is_boat(model: VehicleModel, density_kg_m3: float) -> bool:
    """Return whether a vehicle floats with much of its hull above water of a density."""
    body = rigid_body(model, density_kg_m3)
    return _mass_kg(model, density_kg_m3) <= BOAT * density_kg_m3 * body.volume_m3


def floating_height_m(model: VehicleModel, density_kg_m3: float) -> float:
    """Return the height of a boat's origin above the surface [m], upright, in water of a density."""
    vertices, triangles = vehicle_hull(model)
    corners_m = np.asarray(vertices, np.float64)[triangles]
    low, high = -float(vertices[:, 2].max()), -float(vertices[:, 2].min())
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        is_low = density_kg_m3 * volume_below_m3(corners_m, -middle) > _mass_kg(model, density_kg_m3)
        low, high = (middle, high) if is_low else (low, middle)
    return high


def volume_below_m3(corners_m: NDArray[np.float64], z_m: float) -> float:
    """Return the volume below a height of a closed hull with outward triangles (m, 3, 3).

    By the divergence theorem, it is minus the integral of depth over the area that faces up; over a triangle, that of
    the positive part of a linear depth has a closed form.
    """
    a, b, c = corners_m[:, 0], corners_m[:, 1], corners_m[:, 2]
    up_m2 = 0.5 * np.cross(b - a, c - a)[:, 2]
    d1, d2, d3 = np.sort(z_m - corners_m[..., 2], axis=1)[:, ::-1].T
    with np.errstate(divide="ignore", invalid="ignore"):  # of the cases that do not apply
        one = d1**3 / (3.0 * (d1 - d2) * (d1 - d3))
        two = (d1 + d2 + d3) / 3.0 - d3**3 / (3.0 * (d1 - d3) * (d2 - d3))
    mean_m = np.select([d3 >= 0.0, d2 >= 0.0, d1 > 0.0], [(d1 + d2 + d3) / 3.0, two, one], 0.0)
    return -float(up_m2 @ mean_m)


def _mass_kg(model: VehicleModel, density_kg_m3: float) -> float:
    """Return the mass with ballast and the weights of trim."""
    body = rigid_body(model, density_kg_m3)
    if model.trim is None:
        return body.mass_kg + model.ballast_kg
    return density_kg_m3 * body.volume_m3 - model.trim.net_buoyancy_n / GRAVITY_M_S2 + model.ballast_kg
