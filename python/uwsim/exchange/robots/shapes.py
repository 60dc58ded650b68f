"""Primitive shapes and mesh files of descriptions, as closed meshes."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from uwsim.exchange.robots.robot import Lump, Mesh
from uwsim.exchange.robots.xml_file import Floats, Pose
from uwsim.scenario.read.mesh_file import load_mesh
from uwsim.scenario.read.mesh_repair import closed_mesh

ROUND, BALL = 48, 3
"""Edges of a circle, and subdivisions of an icosahedron: the volume is 0.3 and 0.8 % small, and is scaled to exact."""

SIZE_MAX_M = 1e6
TINY_M3 = 1e-9
"""Solids below this volume stand in for a shape that Gazebo needs, and displace nothing."""


UP_AXIS, ASSET_BYTES = re.compile(rb"<up_axis>\s*([XYZ])_UP"), 1_000_000
"""In the asset of a Collada file, and how much of the file is searched for it."""


def are_sizes(*sizes_m: float) -> bool:
    """Return whether lengths are positive, and not so large that areas and volumes would overflow."""
    return all(0.0 < size <= SIZE_MAX_M for size in sizes_m)


def box(size_m: Floats) -> Mesh:
    """Return a cuboid about its centre."""
    from uwsim.base.whole_trimesh import trimesh

    return _mesh(trimesh.creation.box(size_m))


def cylinder(radius_m: float, length_m: float) -> Mesh:
    """Return a cylinder along z about its centre, with the exact volume."""
    from uwsim.base.whole_trimesh import trimesh

    return _exact(trimesh.creation.cylinder(radius_m, length_m, sections=ROUND), np.pi * radius_m**2 * length_m)


def sphere(radius_m: float) -> Mesh:
    """Return a sphere about its centre, with the exact volume."""
    from uwsim.base.whole_trimesh import trimesh

    return _exact(trimesh.creation.icosphere(BALL, radius_m), 4.0 / 3.0 * np.pi * radius_m**3)


def torus(major_m: float, minor_m: float) -> Mesh:
    """Return a ring about y, of a circle of radius minor_m, with the exact volume."""
    from uwsim.base.whole_trimesh import trimesh

    solid = trimesh.creation.torus(major_m, minor_m, major_sections=ROUND, minor_sections=ROUND // 2)
    solid.vertices = solid.vertices[:, [1, 2, 0]]
    return _exact(solid, 2.0 * np.pi**2 * major_m * minor_m**2)


def capsule(radius_m: float, length_m: float) -> Mesh:
    """Return a cylinder of a length with half spheres at its ends, along z about its centre, with the exact volume."""
    from uwsim.base.whole_trimesh import trimesh

    solid = trimesh.creation.capsule(length_m, radius_m, count=[24, ROUND])
    return _exact(solid, np.pi * radius_m**2 * (length_m + 4.0 / 3.0 * radius_m))


def ellipsoid(radii_m: Floats) -> Mesh:
    """Return an ellipsoid about its centre, with the exact volume."""
    from uwsim.base.whole_trimesh import trimesh

    solid = trimesh.creation.icosphere(BALL, 1.0)
    solid.apply_scale(radii_m)
    return _exact(solid, 4.0 / 3.0 * np.pi * float(np.prod(radii_m)))


def from_file(path: Path, scale: Floats) -> Mesh:
    """Return a mesh file's vertices, scaled by axis. Raises ValueError or OSError.

    Gazebo and RViz apply the unit of a Collada file, but leave its axes as they are, whichever it states is up.
    """
    largest = float(np.abs(scale).max()) or 1.0
    up: Literal["z"] | None = None
    if path.suffix.lower() == ".dae" and path.is_file():
        with path.open("rb") as file:
            declared = UP_AXIS.search(file.read(ASSET_BYTES))
        if declared is None or declared[1] != b"Z":
            if declared is not None and declared[1] != b"Y":
                raise ValueError(f"mesh '{path}': up_axis {declared[1].decode()}_UP: must be Y_UP or Z_UP")
            up = "z"  # as it is
    vertices, triangles = load_mesh(path, largest, up)
    faces = np.asarray(triangles, np.int64)
    return np.asarray(vertices) * (scale / largest), faces if np.prod(scale) > 0.0 else faces[:, ::-1]


def closed(mesh: Mesh, name: str) -> Mesh:
    """Return a mesh closed and winding outward, as a hull is. Raises ScenarioError, with the name."""
    vertices, triangles = closed_mesh(*mesh, name=name)
    return np.asarray(vertices), np.asarray(triangles, np.int64)


def placed(mesh: Mesh, pose: Pose) -> Mesh:
    """Return a mesh in the frame in which its own has a pose."""
    return pose.points(mesh[0]), mesh[1]


def volume_and_centre(mesh: Mesh) -> tuple[float, Floats]:
    """Return the volume that a closed mesh encloses [m3], and its centroid [m]."""
    from uwsim.base.whole_trimesh import trimesh

    solid = trimesh.Trimesh(*mesh, process=False)
    return float(solid.volume), np.asarray(solid.center_mass)


def displaces(mesh: Mesh) -> bool:
    """Return whether a mesh has a volume that matters."""
    corners = mesh[0][mesh[1]]  # which may wind inward
    return abs(float(np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])))) > 6.0 * TINY_M3


def solid_lump(mesh: Mesh, mass_kg: float) -> Lump:
    """Return the mass, centre and inertia of a closed mesh that is filled evenly."""
    from uwsim.base.whole_trimesh import trimesh

    solid = trimesh.Trimesh(*mesh, process=False)
    return Lump(mass_kg, np.asarray(solid.center_mass), np.asarray(solid.moment_inertia) * (mass_kg / solid.volume))


def shell_lump(mesh: Mesh, mass_kg: float) -> Lump:
    """Return the mass, centre and inertia of a mesh whose surface carries the mass evenly.

    The second moment of a triangle of area A about the origin is A / 12 (9 c c^T + sum of v v^T), c its centroid.
    """
    corners = mesh[0][mesh[1]]
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    centres = corners.mean(axis=1)
    centre = areas @ centres / areas.sum()
    corners, centres = corners - centre, centres - centre
    second = 9.0 * np.einsum("t,ti,tj->ij", areas, centres, centres)
    second = (second + np.einsum("t,tki,tkj->ij", areas, corners, corners)) / 12.0 * (mass_kg / areas.sum())
    return Lump(mass_kg, centre, np.trace(second) * np.eye(3) - second)


def area_m2(mesh: Mesh) -> float:
    """Return the area of a mesh's surface."""
    corners = mesh[0][mesh[1]]
    return float(
        0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    )


def joined(meshes: list[Mesh]) -> Mesh:
    """Return all meshes as one."""
    starts = np.cumsum([0, *[len(vertices) for vertices, _ in meshes]])
    return (
        np.concatenate([vertices for vertices, _ in meshes]),
        np.concatenate([triangles + start for (_, triangles), start in zip(meshes, starts, strict=False)]),
    )


def _mesh(solid: Any) -> Mesh:
    faces: NDArray[np.int64] = np.asarray(solid.faces, np.int64)
    return np.asarray(solid.vertices, np.float64), faces


def _exact(solid: Any, volume_m3: float) -> Mesh:
    if volume_m3 > TINY_M3:  # smaller ones lose their faces
        solid.apply_scale(float(np.cbrt(volume_m3 / solid.volume)))
    return _mesh(solid)
