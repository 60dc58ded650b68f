"""Generate assets/meshes/coral_head.glb, a head of massive coral 2 m across with lobes and hollows; needs trimesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from uwsim.scenario.build.cover_meshes import ball, lumps

OUT = Path(__file__).resolve().parents[2] / "assets" / "meshes" / "coral_head.glb"


def main() -> None:
    """Write the mesh, its foot at height 0; glTF is y up."""
    random = np.random.default_rng(4)
    vertices, triangles = ball(4)
    swell = 1 + 0.13 * lumps(vertices, random, 0.7) + 0.05 * lumps(vertices, random, 2.4)
    swell += 0.02 * np.sin(4 * lumps(vertices, random, 5.0))
    vertices = vertices * swell[:, None] * [1.0, 0.9, 0.75]
    vertices[:, 2] -= vertices[:, 2].min()
    x, y, z = vertices.round(3).T
    OUT.write_bytes(trimesh.Trimesh(np.column_stack([x, z, -y]), triangles, process=False).export(file_type="glb"))


if __name__ == "__main__":
    main()
