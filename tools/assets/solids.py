"""Solids for the mesh generators: built with manifold3d, united without overlaps, written as OBJ or coloured glTF."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from manifold3d import Manifold

Point = tuple[float, float, float]
Colour = tuple[float, float, float]
"""Albedo: linear red, green and blue in [0, 1]."""


def box(low: Point, high: Point) -> Manifold:
    """Return the cuboid between two corners."""
    size = np.subtract(high, low)
    return Manifold.cube(tuple(size)).translate(low)


def rod(start: Point, end: Point, radius_m: float, sides: int = 12) -> Manifold:
    """Return a cylinder between two points."""
    along = np.subtract(end, start)
    length = float(np.linalg.norm(along))
    pitch = np.degrees(np.arccos(along[2] / length))
    yaw = np.degrees(np.arctan2(along[1], along[0]))
    return Manifold.cylinder(length, radius_m, circular_segments=sides).rotate((0, pitch, yaw)).translate(start)


def ball(centre: Point, radius_m: float, sides: int = 12) -> Manifold:
    """Return a sphere."""
    return Manifold.sphere(radius_m, sides).translate(centre)


def hull(points: list[Point]) -> Manifold:
    """Return the convex hull of points."""
    return Manifold.hull_points(np.asarray(points, np.float64))


def united(parts: list[Manifold]) -> Manifold:
    """Return the union of solids, without slivers thinner than 0.1 mm."""
    total = Manifold()
    for part in parts:
        total += part
    return total.simplify(1e-4)


def united_by_colour(parts: dict[Colour, list[Manifold]]) -> tuple[Manifold, dict[int, Colour]]:
    """Return the union of solids, and the colour of each original solid by manifold3d's number."""
    originals = {colour: united(solids).as_original() for colour, solids in parts.items()}
    return united(list(originals.values())), {solid.original_id(): colour for colour, solid in originals.items()}


def centroid(solid: Manifold) -> Point:
    """Return the centre of volume, from the tetrahedra formed by the triangles and the origin."""
    mesh = solid.to_mesh()
    corners = np.asarray(mesh.vert_properties, np.float64)[:, :3][np.asarray(mesh.tri_verts)]
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return tuple(volumes @ corners.sum(axis=1) / (4 * volumes.sum()))


def write_obj(solid: Manifold, path: Path, comment: str, parts: dict[Colour, list[Manifold]] | None = None) -> None:
    """Write the solid with vertices rounded to 0.01 mm, and print its size.

    parts: solids by colour. Each triangle has the colour of the nearest, the first of several, by a material in a
    library beside the file; the triangles and their order are the same without.
    """
    mesh = solid.to_mesh()
    vertices = np.round(np.asarray(mesh.vert_properties, np.float64)[:, :3], 5) + 0.0
    triangles = np.asarray(mesh.tri_verts, np.int64)
    lines = [f"# {comment}", *("v {:.5f} {:.5f} {:.5f}".format(*vertex) for vertex in vertices)]
    faces = ["f {} {} {}".format(*(triangle + 1)) for triangle in triangles]
    if parts:
        paints = [f"newmtl paint_{k}\nKd {' '.join(map(str, colour))}\n" for k, colour in enumerate(parts)]
        path.with_suffix(".mtl").write_text("".join(paints))
        lines.insert(1, f"mtllib {path.stem}.mtl")
        nearest = _nearest_part(vertices[triangles].mean(axis=1), list(parts.values()))
        changes = np.flatnonzero(np.diff(nearest, prepend=-1))
        for at in changes[::-1]:
            faces.insert(at, f"usemtl paint_{nearest[at]}")
    path.write_text("\n".join([*lines, *faces]) + "\n")
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    print(
        f"{path.name}: {solid.num_tri()} triangles, {solid.volume():.4f} m3, from {low} to {high} m, "
        f"centre of volume {np.round(centroid(solid), 4)} m"
    )


def _nearest_part(places: np.ndarray, parts: list[list[Manifold]]) -> np.ndarray:
    """Return the part whose surface is nearest to each place (n, 3), the first within 0.1 mm."""
    away = []
    for part in parts:
        mesh = united(part).to_mesh()
        surface = trimesh.Trimesh(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts), process=False)
        away.append(trimesh.proximity.closest_point_naive(surface, places)[1])
    return np.argmin(np.round(away, 4), axis=0)


def write_glb(solid: Manifold, colours: dict[int, Colour], path: Path) -> None:
    """Write the solid as glTF, y up, with one part for each colour; vertices are rounded to 0.01 mm.

    Without colours, it is one part, which has the colour of its material.
    """
    mesh = solid.to_mesh()
    x, y, z = np.round(np.asarray(mesh.vert_properties, np.float64)[:, :3], 5).T + 0.0
    vertices, triangles = np.column_stack([x, z, -y]), np.asarray(mesh.tri_verts, np.int64)
    bounds = np.asarray(mesh.run_index, np.int64) // 3
    numbers = {run: number for number, run in enumerate(colours)}
    colour_of = np.repeat([numbers.get(run, 0) for run in mesh.run_original_id], np.diff(bounds))
    scene = trimesh.Scene()
    if not colours:
        scene.add_geometry(trimesh.Trimesh(vertices, triangles, process=False), geom_name="part", node_name="part")
    for number, colour in enumerate(colours.values()):
        material = trimesh.visual.material.PBRMaterial(baseColorFactor=(*colour, 1.0), metallicFactor=0.0)
        visual = trimesh.visual.TextureVisuals(material=material)
        part = trimesh.Trimesh(vertices, triangles[colour_of == number], visual=visual, process=False)
        part.remove_unreferenced_vertices()
        scene.add_geometry(part, geom_name=f"part_{number:02d}", node_name=f"part_{number:02d}")
    path.write_bytes(scene.export(file_type="glb"))
    print(f"{path.name}: {solid.num_tri()} triangles in {max(len(colours), 1)} colours, {solid.volume():.4f} m3")
