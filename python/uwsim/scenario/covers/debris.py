"""The cover `debris`: what people throw overboard."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from uwsim.scenario.build.cover_meshes import lying_about
from uwsim.scenario.spec.cover import CoverModel, Mesh
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.material import Material, MaterialSpec


class Debris(CoverModel):
    """Bottles, cans, planks, bricks and tyres, lying on the bed. size_m: their length."""

    stance: ClassVar = "on_bed"
    sunk: ClassVar = -0.02

    kind: Literal["debris"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="steel")

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return lying_about(random)
