"""Compares occupancy maps from uwsim's own engine with those from the OctoMap library linked into the native module.

Both insert the same random scans by ray casting. The files must agree in every byte.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from uwsim.evidence.validate.check import Check, within
from uwsim.mapping import OccupancyMap

SCANS, POINTS, RANGE_M = 20, 2000, 30.0


def checks() -> list[Check]:
    """Return the checks: bytes that differ, and occupied voxels."""
    draw = np.random.default_rng(0)
    maps = {engine: OccupancyMap(resolution_m=0.2, engine=engine) for engine in ("octomap", "bricks")}
    for _ in range(SCANS):
        origin = draw.uniform(-10, 10, 3)
        directions = draw.standard_normal((POINTS, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        points = (origin + directions * draw.uniform(1.0, 1.3 * RANGE_M, (POINTS, 1))).astype(np.float32)
        for world in maps.values():
            world.insert_scan(points, origin, max_range_m=RANGE_M)
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for suffix in (".bt", ".ot"):
            files = []
            for engine, world in maps.items():
                path = Path(folder) / f"{engine}{suffix}"
                world.write(path)
                files.append(np.frombuffer(path.read_bytes(), np.uint8))
            same = len(files[0]) == len(files[1])
            differing = float((files[0] != files[1]).sum()) if same else np.inf
            name = f"{suffix}: bytes of {len(files[0])} that differ"
            found.append(within("OctoMap's library", name, 0.0, differing, 1.0, 0.5))
    return found
