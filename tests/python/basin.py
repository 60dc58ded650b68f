"""A test basin: a flat bed with boxes, exposing the simulator attributes that imaging sonars use."""

from types import SimpleNamespace

import numpy as np
import trimesh

from uwsim import _core

BED_M = -20.0


def basin(*boxes: tuple[tuple[float, float, float], tuple[float, float, float]], threads: int = 1) -> SimpleNamespace:
    """Create a flat bed with boxes, each given as (centre, size)."""
    world = _core.World()
    world.set_terrain(np.full((2, 2), BED_M, np.float32), 600.0, (-300.0, -300.0))
    for k, (centre_m, size_m) in enumerate(boxes):
        box = trimesh.creation.box(size_m)
        world.add_solid(f"box{k}", box.vertices + np.array(centre_m), box.faces)
    strengths_db = dict.fromkeys(world.label_names, -15.0) | {"terrain": -30.0}
    return SimpleNamespace(
        world=world, scene=_core.RayScene(world), strengths_db=strengths_db, seed=3, threads=threads, time_ns=0
    )
