"""The cover `starfish`."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from uwsim.scenario.build.cover_meshes import lumps, revolved, unit
from uwsim.scenario.spec.cover import CoverModel, Mesh
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.material import Material, MaterialSpec


class Starfish(CoverModel):
    """Starfish with five arms, whose outline is a superformula (Gielis 2003, Am. J. Bot. 90(3):333)."""

    stance: ClassVar = "on_bed"
    sunk: ClassVar = 0.01

    kind: Literal["starfish"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="coral", colour=(0.60, 0.20, 0.07))

    def is_solid(self) -> bool:
        """See CoverModel: they are soft."""
        return False

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """See CoverModel."""
        return [_star(random) for _ in range(3)]


def _star(random: np.random.Generator) -> Mesh:
    rings, sides = np.array([0.0, 0.25, 0.5, 0.75, 0.92, 1.0]), 40
    vertices, triangles = revolved(rings, np.zeros_like(rings), sides)
    turn = np.arctan2(vertices[:, 1], vertices[:, 0])
    power = random.uniform(1.5, 1.9)
    outline = (np.abs(np.cos(1.25 * turn)) ** power + np.abs(np.sin(1.25 * turn)) ** power) ** (-1 / 0.55)
    outline = outline / outline.max()
    reach = np.hypot(vertices[:, 0], vertices[:, 1])
    dome = 0.16 * np.sqrt(np.clip(1 - reach**2, 0, 1)) * (0.45 + 0.55 * (1 - reach))
    flat = vertices[:, :2] * outline[:, None]
    curl = 0.08 * lumps(np.column_stack([flat, dome]), random, 0.5) * (reach**2)
    vertices = np.column_stack([flat[:, 0] - curl * flat[:, 1], flat[:, 1] + curl * flat[:, 0], dome])
    vertices, triangles = unit((vertices, triangles))
    return vertices - [0, 0, vertices[:, 2].min()], triangles
