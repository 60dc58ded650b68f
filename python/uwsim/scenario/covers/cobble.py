"""The cover `cobble`: round stones."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from uwsim.scenario.build.cover_meshes import stone, unit
from uwsim.scenario.spec.cover import CoverModel, Mesh
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.material import Material, MaterialSpec


class Cobble(CoverModel):
    """Stones that water has rounded, flat on the bed."""

    stance: ClassVar = "on_bed"
    sunk: ClassVar = -0.1

    kind: Literal["cobble"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="rock", colour=(0.34, 0.32, 0.29))

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        found = []
        for _ in range(5):
            vertices, triangles = stone(random, cuts=2, roughness=0.1, divisions=2)
            found.append(unit((vertices * [1.0, 0.85, 0.6], triangles)))
        return found
