"""The obstacle `sphere`."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from uwsim import _core
from uwsim.scenario.build.solids import created
from uwsim.scenario.spec.fields import Name, Size
from uwsim.scenario.spec.material import Material, MaterialSpec
from uwsim.scenario.spec.obstacle import Bed, Placed, Solid

BALL_SUBDIVISIONS = 4
"""Subdivisions of an icosahedron: the facets lie at most 0.1 % of the radius inside the sphere."""


class Sphere(Placed):
    """A sphere.

    position_m: its centre (world), unless it is on_bed. radius_m: its radius.
    """

    kind: Literal["sphere"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="steel")
    radius_m: Size = Field(examples=[1])

    def solid(self, terrain: Bed) -> Solid:
        """See ObstacleModel."""
        vertices, triangles = created("icosphere", BALL_SUBDIVISIONS, self.radius_m)
        shape = _core.RoundShape.sphere(self.position_m, self.radius_m)
        return Solid(vertices + np.asarray(self.position_m), triangles, [shape])
