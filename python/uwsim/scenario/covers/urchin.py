"""The cover `urchin`."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from uwsim.scenario.build.cover_meshes import ball, directions, merged, tube, unit
from uwsim.scenario.spec.cover import CoverModel, Mesh
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.material import Material, MaterialSpec

SPINES = 110


class Urchin(CoverModel):
    """Sea urchins with all their spines. size_m: diameter across the spines."""

    stance: ClassVar = "on_bed"
    sunk: ClassVar = 0.08

    kind: Literal["urchin"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="rock", colour=(0.09, 0.05, 0.09))

    def is_solid(self) -> bool:
        """See CoverModel: spines break."""
        return False

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [_urchin(random) for _ in range(3)]


def _urchin(random: np.random.Generator) -> Mesh:
    body, triangles = ball(1)
    parts = [(body * [0.5, 0.5, 0.36], triangles)]
    for along in directions(SPINES):
        if along[2] < -0.45:
            continue
        out = along + random.normal(0, 0.08, 3)
        tip = out / np.linalg.norm(out) * random.uniform(0.8, 1.05) * [1, 1, 0.85]
        parts.append(tube([0.4 * tip, tip], [0.022, 0.003], 3, closed=False))
    vertices, triangles = unit(merged(parts))
    return vertices - [0, 0, vertices[:, 2].min()], triangles
