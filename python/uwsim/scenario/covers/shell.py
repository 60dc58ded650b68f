"""The cover `shell`: single valves."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from uwsim.scenario.build.cover_meshes import unit
from uwsim.scenario.spec.cover import CoverModel, Mesh
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.material import Material, MaterialSpec

RIBS, RINGS, SIDES = 9, 5, 36


class Shell(CoverModel):
    """Ribbed valves of scallops and cockles, hollow side down."""

    stance: ClassVar = "on_bed"
    sunk: ClassVar = 0.0

    kind: Literal["shell"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="coral", colour=(0.72, 0.64, 0.55))

    def is_solid(self) -> bool:
        """See CoverModel: a body pushes them aside."""
        return False

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [_valve(random) for _ in range(3)]


def _valve(random: np.random.Generator) -> Mesh:
    """Return a fan of ribs from the hinge, domed across."""
    angle = np.linspace(-1.0, 1.0, SIDES)[None, :]
    reach = np.linspace(0.05, 1.0, RINGS)[:, None]
    rib = 1 + 0.05 * np.cos(np.pi * RIBS * angle)
    edge = 0.5 * (1 + np.cos(0.5 * np.pi * angle**2))
    x = reach * np.sin(1.15 * angle) * random.uniform(0.85, 1.0)
    y = reach * np.cos(1.15 * angle) * (0.9 + 0.1 * edge)
    z = random.uniform(0.28, 0.4) * rib * np.sqrt(np.clip(1 - reach**2, 0, 1) + 0.02) * edge * np.sqrt(reach)
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    a = (np.arange(RINGS - 1)[:, None] * SIDES + np.arange(SIDES - 1)).ravel()
    triangles = np.stack([a, a + SIDES, a + 1, a + 1, a + SIDES, a + SIDES + 1], axis=-1).reshape(-1, 3)
    vertices, triangles = unit((vertices, triangles.astype(np.uint32)))
    return vertices - [0.0, 0.0, vertices[:, 2].min()], triangles
