"""The cover `cone`."""

from __future__ import annotations

from typing import Literal

import numpy as np

from uwsim.scenario.build.cover_meshes import revolved
from uwsim.scenario.spec.cover import CoverModel, Mesh
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.material import Material, MaterialSpec


class Cone(CoverModel):
    """Cones, as tall as wide."""

    kind: Literal["cone"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="paint")

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """Return a cone."""
        return [revolved([0.5, 0.0], [0.0, 1.0])]
