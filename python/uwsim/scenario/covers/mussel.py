"""The cover `mussel`: clumps."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from uwsim.scenario.build.cover_meshes import ball, merged, turned_to, unit
from uwsim.scenario.spec.cover import CoverModel, Mesh
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.material import Material, MaterialSpec


class Mussel(CoverModel):
    """Clumps of a dozen mussels. size_m: diameter of the clump."""

    stance: ClassVar = "on_bed"

    kind: Literal["mussel"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="rock", colour=(0.13, 0.12, 0.16))

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [_clump(random) for _ in range(4)]


def _clump(random: np.random.Generator) -> Mesh:
    """Return pointed ovals that stand close together, tips up."""
    vertices, triangles = ball(1)
    narrow = 0.6 + 0.4 * np.clip(0.5 + 0.6 * vertices[:, 2:], 0, 1)
    shell = (vertices * [0.16, 0.10, 0.3] * np.hstack([narrow, narrow, np.ones_like(narrow)]), triangles)
    parts = []
    for _ in range(12):
        at = np.append(random.normal(0, 0.22, 2), random.uniform(0.05, 0.15))
        parts.append(turned_to(shell, np.append(1.5 * at[:2] + random.normal(0, 0.3, 2), 0.8), at))
    vertices, triangles = unit(merged(parts))
    return vertices - [0, 0, vertices[:, 2].min()], triangles
