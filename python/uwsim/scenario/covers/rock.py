"""The cover `rock`: broken stones."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from uwsim.scenario.build.cover_meshes import stone, unit
from uwsim.scenario.spec.cover import CoverModel, Mesh
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.material import Material, MaterialSpec


class Rock(CoverModel):
    """Stones with edges, tumbled; a third of each is in the bed."""

    stance: ClassVar = "tumbled"
    sunk: ClassVar = -0.12

    kind: Literal["rock"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="rock")

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [unit(stone(random, cuts=14, roughness=0.08)) for _ in range(6)]
