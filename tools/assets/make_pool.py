"""Generate the meshes of the scenario `training_pool`: tiled walls, and lane lines, drain and lamps; needs manifold3d.

Metres, z up, z = 0 at the water's surface; the basin is 25 x 20 m and 5 m deep.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from manifold3d import Manifold
from PIL import Image
from solids import Colour, box, rod, united_by_colour, write_glb

MESHES = Path(__file__).resolve().parents[2] / "assets" / "meshes"
HALF_X, HALF_Y, DEPTH = 12.5, 10.0, 5.0
DECK_Z, WALL_M = 0.3, 11.0
TILE_M, TILES, TILE_PX, GROUT_PX = 0.25, 4, 64, 3
SIDES = (-1, 1)


def basin() -> Manifold:
    """Return floor and walls; the walls' tops are the deck around the water."""
    x, y = HALF_X + WALL_M, HALF_Y + WALL_M
    hollow = box((-HALF_X, -HALF_Y, -DEPTH), (HALF_X, HALF_Y, DECK_Z + 1))
    return box((-x, -y, -DEPTH - 0.2), (x, y, DECK_Z)) - hollow


def tiles() -> Image.Image:
    """Return a picture of a square metre of tiles, which repeats."""
    random = np.random.default_rng(25)
    tone = random.normal(1.0, 0.02, (TILES, TILES, 1))
    picture = np.repeat(np.repeat(tone * (196, 222, 230), TILE_PX, axis=0), TILE_PX, axis=1)
    joint = np.arange(TILES * TILE_PX) % TILE_PX < GROUT_PX
    picture[joint], picture[:, joint] = (118, 140, 150), (118, 140, 150)
    return Image.fromarray(np.clip(picture, 0, 255).astype(np.uint8))


def write_tiled(solid: Manifold, path: Path) -> None:
    """Write a solid of axis-parallel faces as glTF, y up, with a square metre of tiles in each texture's unit."""
    mesh = solid.to_mesh()
    corners = np.asarray(mesh.vert_properties, np.float64)[:, :3][np.asarray(mesh.tri_verts)]
    normals = np.abs(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])).argmax(axis=1)
    across = np.array([(1, 2), (0, 2), (0, 1)])[normals]
    uv = np.take_along_axis(corners, across[:, None, :].repeat(3, axis=1), axis=2) / (TILE_M * TILES)
    x, y, z = corners.reshape(-1, 3).T + 0.0
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=tiles(), metallicFactor=0.0)
    visual = trimesh.visual.TextureVisuals(uv=uv.reshape(-1, 2), material=material)
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    found = trimesh.Trimesh(np.column_stack([x, z, -y]), faces, visual=visual, process=False)
    path.write_bytes(trimesh.Scene(found).export(file_type="glb"))
    print(f"{path.name}: {len(faces)} triangles, {path.stat().st_size} bytes")


def lane_lines() -> list[Manifold]:
    """Return a line along the middle of each of eight lanes, with its cross at either end, 1 cm above the floor."""
    low, high = -DEPTH, -DEPTH + 0.01
    parts = []
    for y in np.arange(-8.75, 9.0, 2.5):
        parts.append(box((-HALF_X + 2, y - 0.125, low), (HALF_X - 2, y + 0.125, high)))
        parts += [box((s * 10.5 - 0.125, y - 0.5, low), (s * 10.5 + 0.125, y + 0.5, high)) for s in SIDES]
        for s in SIDES:  # the target on the wall
            inner, outer = sorted((s * (HALF_X - 0.01), s * HALF_X))
            parts.append(box((inner, y - 0.125, -2.2), (outer, y + 0.125, -0.3)))
            parts.append(box((inner, y - 0.25, -1.3), (outer, y + 0.25, -1.05)))
    return parts


def drain() -> list[Manifold]:
    """Return a grating of 1 x 1 m at the floor's middle."""
    low, high = -DEPTH, -DEPTH + 0.02
    bars = [box((-0.5, y - 0.03, low), (0.5, y + 0.03, high)) for y in np.arange(-0.4, 0.41, 0.1)]
    frame = box((-0.55, -0.55, low), (0.55, 0.55, high)) - box((-0.47, -0.47, low - 1), (0.47, 0.47, high + 1))
    return [*bars, frame]


def lamps(radius_m: float, proud_m: float) -> list[Manifold]:
    """Return a disc on the wall for each of five lamps along either long side."""
    places = [(x, s) for x in (-10, -5, 0, 5, 10) for s in SIDES]
    return [rod((x, s * HALF_Y, -1.2), (x, s * (HALF_Y - proud_m), -1.2), radius_m, sides=24) for x, s in places]


def main() -> None:
    """Write the meshes."""
    write_tiled(basin(), MESHES / "pool.glb")
    edge = box((-HALF_X - 0.3, -HALF_Y - 0.3, DECK_Z), (HALF_X + 0.3, HALF_Y + 0.3, DECK_Z + 0.02))
    edge -= box((-HALF_X, -HALF_Y, 0), (HALF_X, HALF_Y, 1))
    pit = box((-0.47, -0.47, -DEPTH), (0.47, 0.47, -DEPTH + 0.005))
    parts: dict[Colour, list[Manifold]] = {
        (0.02, 0.05, 0.20): lane_lines(),
        (0.01, 0.01, 0.01): [pit],
        (0.45, 0.46, 0.47): [*drain(), *lamps(0.20, 0.03)],
        (1.00, 0.97, 0.86): lamps(0.16, 0.05),
        (0.12, 0.30, 0.45): [edge],
    }
    write_glb(*united_by_colour(parts), MESHES / "pool_fittings.glb")


if __name__ == "__main__":
    main()
