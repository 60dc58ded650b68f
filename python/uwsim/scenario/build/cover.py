"""A scenario's cover, added to the core's world and to its camera scene."""

from __future__ import annotations

import zlib

import numpy as np

from uwsim import _core
from uwsim.scenario.spec.cover import ANYWHERE_M, CoverModel


def add_cover(world: _core.World, layer: CoverModel) -> None:
    """Add a layer to a world whose solids are complete. Raises ScenarioError or ValueError."""
    near_m, far_m = layer.obstacles_m
    random = np.random.default_rng([layer.seed, zlib.crc32(layer.kind.encode())])
    world.add_cover(
        layer.name,
        layer.meshes(random),
        stance=layer.stance,
        sunk=layer.sunk,
        density_per_m2=layer.density_per_m2,
        size_m=layer.size_m,
        size_exponent=layer.size_exponent,
        depth_m=layer.depth_m,
        slope_rad=tuple(np.radians(layer.slope_deg)),
        from_solids_m=(near_m, far_m if far_m < ANYWHERE_M else np.inf),
        patch_m=layer.patch_m,
        patch_share=layer.patch_share,
        seed=layer.seed,
        solid=layer.is_solid(),
        drag_coefficient=layer.drag_coefficient,
        leans_at_m_s=np.inf if layer.leans_at_m_s is None else layer.leans_at_m_s,
    )


def set_cover_appearance(scene: _core.CameraScene, label: int, layer: CoverModel) -> None:
    """Set material, class and texture of a layer."""
    texture = layer.texture()
    colour = None if texture is not None else layer.material.colour
    kind = layer.surface_class or layer.kind
    scene.set_cover_appearance(label, layer.material.looks, kind, colour, *texture or ())
